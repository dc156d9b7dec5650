#include <algorithm>
#include <memory>

#include "arguments/problem_arguments.hpp"
#include "arguments/shared_arguments.hpp"
#include "base/json/ordered_json.hpp"
#include "commands/commands.hpp"
#include "problem_file/expand/expand_problem.hpp"
#include "problem_file/expand/problem_summary.hpp"
#include "solvers/strategies/registry.hpp"
#include "summary/summary.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/messages.hpp"
#include "terminal/streams.hpp"

namespace conddp {
namespace {

struct CheckArguments : ProblemArguments {
  std::string expand;  ///< rewriting after which the problem is printed; empty: none
  bool derivatives = false;
  bool terminal = false;
};

/// The summary, with derivatives and terminal ingredients if they were checked.
std::string full_text(const OrderedJson& summary) {
  std::string text = check_text(summary);
  if (summary.contains("derivatives")) text += derivatives_text(summary["derivatives"]);
  if (summary.contains("terminal_lqr")) text += regulator_text(summary["terminal_lqr"]);
  return text;
}

/// Builds the closed loop of a file that contains one. Reports only errors of the loop; those of
/// its problem have been reported.
std::unique_ptr<LoopTask> loop_of(const CheckArguments& arguments, const BuiltProblem& built,
                                  Diagnostics& out) {
  if (!built.facts().mpc) return nullptr;
  Diagnostics own = out;
  auto task = build_loop(built, build_options_of(arguments), own);
  const std::vector<Diagnostic> said = out.list();
  for (const Diagnostic& d : own.list()) {
    const auto is_same = [&d](const Diagnostic& other) {
      return d.message == other.message && d.line == other.line && d.column == other.column;
    };
    if (std::none_of(said.begin(), said.end(), is_same)) out.add(d);
  }
  return task;
}

int print_summary(const CheckArguments& arguments, const BuiltProblem& built,
                  const std::vector<const SolverInfo*>& candidates, const LoopTask* loop) {
  OrderedJson summary = problem_summary(built, candidates, loop == nullptr ? nullptr : &loop->mpc);
  if (arguments.derivatives)
    summary["derivatives"] =
        derivatives_json(check_derivatives(*built.problem, built.guess), built);
  if (arguments.terminal)
    summary["terminal_lqr"] =
        regulator_json(built, built.facts().solver.options.tolerances.constraint);
  print_result(arguments.json ? json_text(summary) : full_text(summary));
  const bool wrong = arguments.derivatives && !summary["derivatives"]["holds"].get<bool>();
  return wrong ? kExitNotConverged : kExitConverged;
}

int check_file(const CheckArguments& arguments) {
  Diagnostics diagnostics;
  const auto built = build_problem_of(arguments, build_options_of(arguments), diagnostics);
  const auto candidates =
      built ? usable_solvers(*built, diagnostics) : std::vector<const SolverInfo*>();
  if (arguments.terminal && built && !built->terminal_lqr)
    diagnostics.error({{}, "terminal"},
                      "--terminal needs 'terminal: {lqr: STATE}', which the file does not have",
                      "write it, or give --set terminal.lqr=STATE");
  const auto loop = candidates.empty() ? nullptr : loop_of(arguments, *built, diagnostics);
  if (!arguments.expand.empty() && built) warn_of_lost_gait(*built, diagnostics);
  print_messages(diagnostics, verbosity_of(arguments));
  if (candidates.empty() || diagnostics.has_errors()) return kExitBadInput;
  if (arguments.expand.empty()) return print_summary(arguments, *built, candidates, loop.get());
  if (arguments.json)
    print_result(json_text(expand_after(arguments.expand, *built)));
  else
    print_result(expanded_text(*built, arguments.expand));
  return kExitConverged;
}

}  // namespace

Command check_command() {
  const auto a = std::make_shared<CheckArguments>();
  return {.name = "conddp check",
          .description = "Check a problem file without solving it",
          .arguments = joined(
              problem_arguments(*a),
              {{.names = {"--expand"},
                .value = "REWRITING",
                .description = "Print the file with every default filled in, as it is after this "
                               "rewriting",
                .choices = names_of_rewritings(),
                .fallback = std::string(kWholeFile),
                .implied = std::string(kWholeFile),
                .target = &a->expand},
               flag({"--derivatives"}, a->derivatives,
                    "Compare every derivative with dual numbers, those of compiled functions with "
                    "differences of their values, and name the worst entries; exit status 1 if one "
                    "is wrong",
                    "--expand"),
               flag({"--terminal"}, a->terminal,
                    "Print the regulator of 'terminal: {lqr: ...}', its largest terminal set, and "
                    "which conditions of a stable closed loop hold on samples of it",
                    "--expand"),
               flag({"--json"}, a->json, "Print JSON on stdout"),
               flag({"-v", "--verbose"}, a->verbose, "Print notes too")}),
          .run = [a] { return check_file(*a); }};
}

}  // namespace conddp
