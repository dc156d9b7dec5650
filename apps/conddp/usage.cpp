#include "usage.hpp"

#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "robot/near_names.hpp"

namespace conddp {
namespace {

std::vector<std::string> subcommand_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(sub->get_name());
  return names;
}

std::vector<std::string> flag_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

/// The subcommand on the command line, or null.
const CLI::App* chosen(const CLI::App& app, const std::vector<std::string>& arguments) {
  for (const std::string& argument : arguments)
    for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; }))
      if (sub->get_name() == argument) return sub;
  return nullptr;
}

}  // namespace

std::string usage_error(const CLI::App& app, const CLI::ParseError& error, int argc, char** argv) {
  const std::vector<std::string> arguments(argv + std::min(1, argc), argv + argc);
  const CLI::App* sub = chosen(app, arguments);
  std::string message = error.what();
  std::string hint;
  if (sub == nullptr) {
    for (const std::string& argument : arguments) {
      if (argument.starts_with('-')) continue;
      message = fmt::format("there is no subcommand '{}'", argument);
      hint = name_hint(argument, subcommand_names(app), "subcommands");
      break;
    }
    if (arguments.empty()) {
      message = "a subcommand is required";
      hint = name_hint("solve?", subcommand_names(app), "subcommands");
    }
  }
  const CLI::App& scope = sub != nullptr ? *sub : app;
  if (hint.empty()) {
    for (const std::string& argument : arguments) {
      const std::string flag = argument.substr(0, argument.find('='));
      if (!flag.starts_with("--") || flag.size() < 3) continue;
      const std::vector<std::string> known = flag_names(scope);
      if (std::find(known.begin(), known.end(), flag) != known.end()) continue;
      message = fmt::format("there is no option '{}'", flag);
      hint = name_hint(flag, known, "options");
      break;
    }
  }
  std::string text = fmt::format("conddp: error: {}\n", message);
  if (!hint.empty()) text += fmt::format("  hint: {}\n", hint);
  text += sub != nullptr ? fmt::format("'conddp {} --help' lists what it takes.\n", sub->get_name())
                         : "'conddp --help' lists the subcommands.\n";
  return text;
}

}  // namespace conddp
