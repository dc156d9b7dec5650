#include <algorithm>
#include <memory>

#include "arguments/problem_arguments.hpp"
#include "arguments/shared_arguments.hpp"
#include "base/json/json_text.hpp"
#include "commands/commands.hpp"
#include "output/mpc/loop_task.hpp"
#include "problem_file/build/build_problem.hpp"
#include "problem_file/expand/expand_problem.hpp"
#include "solvers/strategies/registry.hpp"
#include "summary/check_summary.hpp"
#include "summary/derivative_report.hpp"
#include "summary/regulator_report.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/messages.hpp"
#include "terminal/streams.hpp"

namespace conddp {
namespace {

struct CheckArguments : ProblemArguments {
  std::string expand;  ///< rewriting after which the problem is printed; empty: none
  bool derivatives = false;
  bool terminal = false;
  bool json = false;
  bool verbose = false;
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
std::unique_ptr<LoopTask> loop_of(const CheckArguments& arguments, const ProblemSpec& spec,
                                  Diagnostics& out) {
  if (!spec.mpc) return nullptr;
  Diagnostics own = out;
  auto task = build_loop(spec, {.drop = arguments.drop}, own);
  const std::vector<Diagnostic> said = out.list();
  for (const Diagnostic& d : own.list()) {
    const auto is_same = [&d](const Diagnostic& other) {
      return d.message == other.message && d.line == other.line && d.column == other.column;
    };
    if (std::none_of(said.begin(), said.end(), is_same)) out.add(d);
  }
  return task;
}

int print_summary(const CheckArguments& arguments, const ProblemSpec& spec,
                  const BuiltProblem& built, const std::vector<const SolverInfo*>& candidates,
                  const LoopTask* loop) {
  OrderedJson summary =
      check_summary(spec, built, candidates, loop == nullptr ? nullptr : &loop->mpc);
  if (arguments.derivatives)
    summary["derivatives"] =
        derivatives_json(check_derivatives(*built.problem, built.guess), spec, built);
  if (arguments.terminal)
    summary["terminal_lqr"] = regulator_json(built, spec.solver.options.tolerances.constraint);
  print_result(arguments.json ? json_text(summary) : full_text(summary));
  const bool wrong = arguments.derivatives && !summary["derivatives"]["holds"].get<bool>();
  return wrong ? kExitNotConverged : kExitConverged;
}

int check_file(const CheckArguments& arguments) {
  Diagnostics diagnostics;
  const Verbosity verbosity = arguments.verbose ? Verbosity::kVerbose : Verbosity::kNormal;
  const auto spec = read_problem_of(arguments, diagnostics);
  const auto built = spec ? build_problem(*spec, {.drop = arguments.drop}, diagnostics)
                          : std::optional<BuiltProblem>();
  const auto candidates = built ? usable_solvers(*spec, *built->problem, diagnostics)
                                : std::vector<const SolverInfo*>();
  if (arguments.terminal && built && !built->terminal_lqr)
    diagnostics.error({{}, "terminal"},
                      "--terminal needs 'terminal: {lqr: STATE}', which the file does not have",
                      "write it, or give --set terminal.lqr=STATE");
  const auto loop = candidates.empty() ? nullptr : loop_of(arguments, *spec, diagnostics);
  if (!arguments.expand.empty() && built) warn_of_lost_gait(*spec, diagnostics);
  print_messages(diagnostics, verbosity);
  if (candidates.empty() || diagnostics.has_errors()) return kExitBadInput;
  if (arguments.expand.empty())
    return print_summary(arguments, *spec, *built, candidates, loop.get());
  const OrderedJson problem = expand_after(arguments.expand, *spec, *built);
  print_result(arguments.json ? json_text(problem) : expanded_text(problem, spec->text));
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
