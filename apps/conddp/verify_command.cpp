#include <algorithm>

#include <fmt/format.h>

#include "commands.hpp"
#include "exit_codes.hpp"
#include "messages.hpp"
#include "output/certificate_report.hpp"
#include "output/json_text.hpp"
#include "output/solution_certificate.hpp"
#include "output/solution_members.hpp"
#include "problem_file/expand_problem.hpp"
#include "problem_file/read_problem.hpp"
#include "problem_file/solution_document.hpp"
#include "streams.hpp"

namespace conddp {
namespace {

namespace fs = std::filesystem;

struct VerifyArguments {
  std::string solution;
  std::string problem;
  bool json = false;
  bool quiet = false;
};

/// What a solution says about the files it was made from.
struct Sources {
  std::string problem;
  std::string sha256;
  std::vector<std::string> overrides;
  std::vector<std::string> drop;
  std::vector<InputFile> robots, data_files;
};

std::vector<InputFile> files(const OrderedJson& array) {
  std::vector<InputFile> all;
  for (const OrderedJson& file : array)
    all.push_back({solution_text(file, "file"), solution_text(file, "sha256")});
  return all;
}

Sources sources(const OrderedJson& document) {
  const OrderedJson& problem = solution_member(document, "problem");
  Sources s{.problem = solution_text(problem, "file"), .sha256 = solution_text(problem, "sha256")};
  for (const OrderedJson& setting : solution_list(problem, "overrides")) {
    if (!setting.is_string()) throw MalformedSolution{"'overrides' has an entry that is no text"};
    // Where the solve began has no part in the answer, and that file may be gone.
    if (std::string value = setting; !value.starts_with("initial_guess"))
      s.overrides.push_back(std::move(value));
  }
  for (const OrderedJson& dropped : solution_list(document, "dropped_constraints"))
    s.drop.push_back(solution_text(dropped, "name"));
  s.robots = files(solution_list(problem, "robots"));
  s.data_files = files(solution_list(problem, "data_files"));
  return s;
}

/// The file as the solution names it, seen from here or from a folder above the solution.
fs::path find_problem(const std::string& name, const std::string& solution) {
  std::error_code error;
  if (fs::exists(name, error)) return name;
  fs::path folder = fs::absolute(solution, error).parent_path();
  for (; folder.has_relative_path(); folder = folder.parent_path())
    if (fs::exists(folder / name, error)) return folder / name;
  return name;
}

void warn_if_changed(const std::string& what, const std::string& then, const std::string& now,
                     Diagnostics& out) {
  if (then == now) return;
  out.add({.file = what,
           .severity = Severity::kWarning,
           .message = "this file has changed since the solution was made (its SHA-256 differs)"});
}

void compare_files(const Sources& s, const ProblemSpec& spec, const BuiltProblem& built,
                   Diagnostics& out) {
  warn_if_changed(spec.file.string(), s.sha256, spec.sha256, out);
  const auto& parts = built.plant.parts;
  for (std::size_t i = 0; i < parts.size(); ++i)
    warn_if_changed(parts[i].spec->path.string(), i < s.robots.size() ? s.robots[i].sha256 : "",
                    parts[i].sha256, out);
  for (const InputFile& now : built.data_files)
    for (const InputFile& then : s.data_files)
      if (fs::path(then.file).filename() == fs::path(now.file).filename())
        warn_if_changed(now.file, then.sha256, now.sha256, out);
}

/// Whether the problem that the solution writes down is the one that was built.
Check check_configuration(const OrderedJson& document, const ProblemSpec& spec,
                          const BuiltProblem& built) {
  OrderedJson claimed = solution_member(document["problem"], "configuration");
  OrderedJson actual = expand_problem(spec, built);
  for (OrderedJson* json : {&claimed, &actual})
    if (json->is_object()) json->erase("initial_guess");
  // The file's text is what counts: numbers there and here are rounded alike.
  actual = OrderedJson::parse(actual.dump());
  Check check{"configuration"};
  const OrderedJson patch = OrderedJson::diff(actual, claimed);
  if (patch.empty()) return check;
  check.holds = false;
  check.message = "differs from the problem at " + patch[0]["path"].get<std::string>();
  if (patch.size() > 1) check.message += fmt::format(" and {} more places", patch.size() - 1);
  return check;
}

int print(const VerifyArguments& arguments, const ProblemSpec& spec,
          const SolutionCertificate& certificate) {
  if (arguments.json) {
    print_result(json_text(OrderedJson{{"format", "conddp.verify/1"},
                                       {"solution", arguments.solution},
                                       {"problem", spec.file.string()},
                                       {"name", spec.name.value},
                                       {"certificate", certificate_json(certificate)}}));
  } else if (!arguments.quiet) {
    print_result(
        fmt::format("{}: the certificate {}\n", spec.name.value, certificate_line(certificate)));
    print_result(certificate_table(certificate));
    if (!certificate.replay) return kExitNotConverged;
    print_result(fmt::format("  replay {}\n", replay_line(certificate)));
    for (const std::string& warning : replay_warnings(certificate))
      print_result(fmt::format("  warning {}\n", warning));
  }
  return certificate.checks.holds() ? kExitConverged : kExitNotConverged;
}

int verify(const VerifyArguments& arguments) {
  Diagnostics diagnostics;
  const auto give_up = [&] {
    print_messages(diagnostics, Verbosity::kNormal);
    return kExitBadInput;
  };
  constexpr std::string_view kKeys[] = {
      "problem",      "solver",     "status",      "cost",
      "cost_by_name", "iterations", "residuals",   "dropped_constraints",
      "trajectory",   "gains",      "multipliers", "log"};
  const auto loaded = load_solution_document(arguments.solution, kKeys, {}, diagnostics);
  if (!loaded) return give_up();
  const OrderedJson document(*loaded);
  try {
    const Sources s = sources(document);
    const fs::path file = arguments.problem.empty() ? find_problem(s.problem, arguments.solution)
                                                    : fs::path(arguments.problem);
    std::error_code error;
    if (arguments.problem.empty() && !fs::exists(file, error)) {
      diagnostics.add({.file = arguments.solution,
                       .message = fmt::format("its problem '{}' is not there", s.problem),
                       .hint = "say with --problem where it is now"});
      return give_up();
    }
    auto spec = read_problem(file, s.overrides, diagnostics);
    if (!spec) return give_up();
    spec->guess = {};
    const auto built = build_problem(*spec, {.drop = s.drop}, diagnostics);
    if (!built) return give_up();
    compare_files(s, *spec, *built, diagnostics);
    print_messages(diagnostics, arguments.quiet ? Verbosity::kQuiet : Verbosity::kNormal);
    SolutionCertificate certificate = certify_solution(document, *spec, *built, true);
    auto& checks = certificate.checks.checks;
    checks.insert(checks.begin(), check_configuration(document, *spec, *built));
    return print(arguments, *spec, certificate);
  } catch (const MalformedSolution& malformed) {
    diagnostics.add({.file = arguments.solution,
                     .message = "the solution cannot be used: " + malformed.message});
  } catch (const OrderedJson::exception& error) {
    diagnostics.add({.file = arguments.solution,
                     .message = fmt::format("the solution cannot be used: {}", error.what())});
  }
  return give_up();
}

}  // namespace

void add_verify_command(CLI::App& app, Command& chosen) {
  CLI::App* command = app.add_subcommand("verify", "Check a solution by code that no solver uses");
  const auto a = std::make_shared<VerifyArguments>();
  command->add_option("FILE", a->solution, "Solution")->required()->type_name("FILE.json");
  command
      ->add_option("--problem", a->problem,
                   "Problem file; the one that the solution names if nothing is said")
      ->type_name("FILE.yaml");
  auto* quiet = command->add_flag("--quiet", a->quiet, "Print nothing but errors");
  command->add_flag("--json", a->json, "Print JSON on stdout")->excludes(quiet);
  command->footer(
      "Simulates every knot again and compares costs, gaps, bounds, multipliers and the gradient "
      "of "
      "the Lagrangian with what the solution says of itself. Exit status 0 if all of it holds, 1 "
      "if "
      "not.");
  command->callback([a, &chosen] { chosen = [a] { return verify(*a); }; });
}

}  // namespace conddp
