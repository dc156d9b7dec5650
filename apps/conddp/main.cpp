#include <cstdio>
#include <exception>
#include <new>
#include <string>

#include <fmt/format.h>

#include "commands.hpp"
#include "conddp_version.hpp"
#include "exit_codes.hpp"
#include "usage.hpp"

namespace {

std::string version_text() {
  const conddp::BuildInfo& info = conddp::build_info();
  std::string text = fmt::format("conddp {} (revision {}{})\n{}, {}, {}\n", info.version,
                                 info.revision, info.dirty ? ", modified" : "", info.compiler,
                                 info.build_type, info.instruction_set);
  for (const conddp::LibraryVersion& library : info.libraries)
    text += fmt::format("{} {}\n", library.name, library.version);
  text.pop_back();
  return text;
}

int run(int argc, char** argv) {
  CLI::App app{"Batch trajectory optimisation of robots under constraints", "conddp"};
  app.require_subcommand(1);
  app.set_version_flag("--version", version_text(), "Print the version and how it was built");
  conddp::Command chosen;
  conddp::add_solve_command(app, chosen);
  conddp::add_check_command(app, chosen);
  conddp::add_inspect_command(app, chosen);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& e) {
    return app.exit(e);
  } catch (const CLI::ParseError& e) {
    std::fputs(conddp::usage_error(app, e, argc, argv).c_str(), stderr);
    return conddp::kExitBadInput;
  }
  return chosen();
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::bad_alloc&) {
    std::fputs("conddp: error: there is not enough memory\n", stderr);
    return conddp::kExitBadInput;
  } catch (const std::exception& e) {
    fmt::print(stderr,
               "conddp: internal error: {}\nThis is a defect of conddp. Please report it with the "
               "command and its files (version {}, revision {}).\n",
               e.what(), conddp::build_info().version, conddp::build_info().revision);
  } catch (...) {
    std::fputs("conddp: internal error of unknown kind. Please report it.\n", stderr);
  }
  return conddp::kExitDefect;
}
