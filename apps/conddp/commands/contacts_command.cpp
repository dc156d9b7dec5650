#include <fmt/format.h>

#include "arguments/shared_arguments.hpp"
#include "base/files/atomic_file.hpp"
#include "base/json/json_document.hpp"
#include "commands/commands.hpp"
#include "output/report/contact_report.hpp"
#include "output/schedule/contact_schedule.hpp"
#include "output/solution/solution_json.hpp"
#include "output/solution/solved_problem.hpp"
#include "problem_file/yaml/yaml_text.hpp"
#include "solvers/strategies/registry.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/messages.hpp"
#include "terminal/streams.hpp"

namespace conddp {
namespace {

struct ContactsArguments {
  std::string solution;
  std::string output;
  std::string problem;
  std::string solver = "proxddp";
};

/// The states and controls of a solution, which must be finite.
Trajectory finite_trajectory(const OrderedJson& document, const ShootingProblem& problem) {
  Trajectory trajectory = stored_trajectory(document, problem);
  bool finite = trajectory.x(problem.knots()).allFinite();
  for (int k = 0; k < problem.knots(); ++k)
    finite = finite && trajectory.x(k).allFinite() && trajectory.u(k).allFinite();
  if (!finite) throw MalformedSolution{"'trajectory' has an entry that is not a number"};
  return trajectory;
}

ScheduleOptions options_of(const ContactsArguments& arguments) {
  ScheduleOptions options;
  options.solver = arguments.solver;
  options.supports_constraints =
      find_solver(arguments.solver)->constraints == ConstraintSupport::all;
  options.folder = std::filesystem::absolute(arguments.output).parent_path();
  options.solution = std::filesystem::absolute(arguments.solution);
  return options;
}

int write_schedule(const ContactsArguments& arguments) {
  Diagnostics diagnostics;
  const auto give_up = [&](const std::string& message) {
    if (!message.empty()) diagnostics.add({.file = arguments.solution, .message = message});
    print_messages(diagnostics, Verbosity::kNormal);
    return kExitBadInput;
  };
  constexpr std::string_view kKeys[] = {"problem", "solver", "status", "trajectory",
                                        "dropped_constraints"};
  const auto loaded = load_document(arguments.solution, kSolutionDocument, kKeys, {}, diagnostics);
  if (!loaded) return give_up({});
  const OrderedJson document(*loaded);
  try {
    const auto solved =
        rebuild_problem(document, arguments.solution, arguments.problem, diagnostics);
    if (!solved) return give_up({});
    const Trajectory trajectory = finite_trajectory(document, *solved->problem);
    const auto motion = contact_motion(*solved->problem, trajectory);
    if (!motion)
      return give_up(
          "its problem has no 'contact_candidates', so the contact sequence is not part of the "
          "solution");
    const ContactSchedule schedule = contact_schedule(*solved, *motion, options_of(arguments));
    if (const std::string status = solution_text(document, "status");
        status != to_string(SolveStatus::converged) &&
        status != to_string(SolveStatus::cost_settled))
      diagnostics.add(
          {.file = arguments.solution,
           .severity = Severity::kWarning,
           .message = fmt::format(
               "the solve did not converge ({}): its contacts may belong to an infeasible motion",
               status),
           .hint = "'conddp verify' shows which checks fail"});
    AtomicFiles files;
    files.add(arguments.output, yaml_text(schedule.problem));
    files.commit();
    for (const std::string& note : schedule.notes)
      diagnostics.add(
          {.file = arguments.solution, .severity = Severity::kWarning, .message = note});
    print_messages(diagnostics, Verbosity::kNormal);
    print_result(fmt::format("{}\n  written {}\n", contact_sequence_text(certify_contacts(*motion)),
                             arguments.output));
    return kExitConverged;
  } catch (const MalformedSolution& malformed) {
    return give_up("the solution cannot be used: " + std::string(malformed.what()));
  } catch (const NoSchedule& none) {
    return give_up("there is no schedule of its contacts: " + std::string(none.what()));
  }
}

}  // namespace

Command contacts_command() {
  const auto a = std::make_shared<ContactsArguments>();
  return {.name = "conddp contacts",
          .description =
              "Turn the contact sequence of a solution into a problem with scheduled contacts",
          .details =
              "Each run of steps with the same closed contacts becomes a phase, each touchdown an "
              "impulse, and the motion the first guess. Joint stops become bounds on positions, "
              "friction becomes cones; for solvers without constraints all of these become costs. "
              "A warning reports what the file cannot express.",
          .arguments = {{.names = {"FILE"},
                         .value = "FILE.json",
                         .description = "Solution",
                         .required = true,
                         .target = &a->solution},
                        {.names = {"-o", "--output"},
                         .value = "FILE.yaml",
                         .description = "Problem file to write",
                         .required = true,
                         .target = &a->output},
                        problem_of_solution(
                            a->problem, "Problem file (default: the one named in the solution)"),
                        solver_argument(a->solver, "Solver of the new problem (default: proxddp)")},
          .run = [a] { return write_schedule(*a); }};
}

}  // namespace conddp
