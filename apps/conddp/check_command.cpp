#include "base/json_text.hpp"
#include "check_summary.hpp"
#include "commands.hpp"
#include "derivative_report.hpp"
#include "exit_codes.hpp"
#include "messages.hpp"
#include "problem_arguments.hpp"
#include "problem_file/build/build_problem.hpp"
#include "problem_file/expand/expand_problem.hpp"
#include "solvers/strategies/registry.hpp"
#include "streams.hpp"

namespace conddp {
namespace {

struct CheckArguments : ProblemArguments {
  bool expand = false;
  bool derivatives = false;
  bool json = false;
  bool verbose = false;
};

int check_file(const CheckArguments& arguments) {
  Diagnostics diagnostics;
  const Verbosity verbosity = arguments.verbose ? Verbosity::kVerbose : Verbosity::kNormal;
  auto spec = read_problem_of(arguments, diagnostics);
  if (spec && !arguments.solver.empty()) spec->solver.name = {arguments.solver, {}};
  const auto built = spec ? build_problem(*spec, {.drop = arguments.drop}, diagnostics)
                          : std::optional<BuiltProblem>();
  const auto candidates = built ? usable_solvers(*spec, *built->problem, diagnostics)
                                : std::vector<const SolverInfo*>();
  print_messages(diagnostics, verbosity);
  if (candidates.empty()) return kExitBadInput;
  if (arguments.expand) {
    print_result(arguments.json ? json_text(expand_problem(*spec, *built))
                                : expanded_text(*spec, *built));
    return kExitConverged;
  }
  OrderedJson summary = check_summary(*spec, *built, candidates);
  bool holds = true;
  if (arguments.derivatives) {
    summary["derivatives"] =
        derivatives_json(check_derivatives(*built->problem, built->guess), *spec, *built);
    holds = summary["derivatives"]["holds"];
  }
  if (arguments.json) {
    print_result(json_text(summary));
  } else {
    print_result(check_text(summary));
    if (arguments.derivatives) print_result(derivatives_text(summary["derivatives"]));
  }
  return holds ? kExitConverged : kExitNotConverged;
}

}  // namespace

void add_check_command(CLI::App& app, Command& chosen) {
  CLI::App* command = app.add_subcommand("check", "Check a problem file without solving it");
  const auto a = std::make_shared<CheckArguments>();
  add_problem_arguments(*command, *a);
  auto* expand =
      command->add_flag("--expand", a->expand, "Print the file with every default filled in");
  command
      ->add_flag("--derivatives", a->derivatives,
                 "Compare every derivative with dual numbers and name the worst entries; exit "
                 "status 1 if one is wrong")
      ->excludes(expand);
  command->add_flag("--json", a->json, "Print JSON on stdout");
  command->add_flag("-v,--verbose", a->verbose, "Print notes too");
  command->callback([a, &chosen] { chosen = [a] { return check_file(*a); }; });
}

}  // namespace conddp
