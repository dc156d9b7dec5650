#pragma once

#include <memory>
#include <string>
#include <vector>

#include "problem_file/build/guess_builder.hpp"
#include "problem_file/build/phase_builder.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {

struct BuildOptions {
  /// Names of constraints to leave out.
  std::vector<std::string> drop;
  /// What moves, where it was built before from the same robots or system; null: it is built.
  const Plant* plant = nullptr;
};

/// A constraint that was left out, kept so that its violation can be reported.
struct DroppedConstraint {
  std::string name;
  std::optional<PhaseBounds> bounds;             ///< of bounds on the control
  std::shared_ptr<const ShootingProblem> alone;  ///< else: a problem with nothing but it
};

class Homotopy;

/// A problem ready to be solved.
struct BuiltProblem {
  Plant plant;
  std::shared_ptr<const ShootingProblem> problem;
  std::vector<Column> state_columns;  ///< augmented states included
  int integrals = 0;                  ///< so many of them, behind those of the system
  /// Linear controls, at the nodes, are among the states; here are those at the ends of knots,
  /// named with kEndOfKnot before.
  std::vector<Column> control_columns;
  Trajectory guess;
  GuessUsed guess_used;
  std::shared_ptr<const DualGuess> multipliers;     ///< to start from, null: none
  std::shared_ptr<const Homotopy> homotopy;         ///< that of the file, null: none
  std::shared_ptr<const TerminalLqr> terminal_lqr;  ///< of `terminal: {lqr: ...}`, null: none
  std::vector<DroppedConstraint> dropped;
  std::vector<InputFile> data_files;  ///< read for references and the guess
};

/// Builds the problem that a spec describes, at the end of its homotopy if it has one. Unknown
/// names of frames, joints, phases, solvers and so on are reported with their places and similar
/// names.
std::optional<BuiltProblem> build_without_homotopy(const ProblemSpec& spec,
                                                   const BuildOptions& options, Diagnostics& out);

/// The solver that the spec names, or those that `auto` tries, the first one first. None where it
/// cannot take the problem: then the reason is reported.
std::vector<const SolverInfo*> usable_solvers(const ProblemSpec& spec,
                                              const ShootingProblem& problem, Diagnostics& out);

/// The names of all constraints, which can be dropped.
std::vector<std::string> constraint_names(const ProblemSpec& spec);

/// The integrator of systems whose problem file names none.
Integrator default_integrator(SystemKind kind);

/// Names of the tangent vectors of states, augmented states included.
std::vector<std::string> tangent_columns(const BuiltProblem& built);

/// Largest violation of a dropped constraint by a trajectory, in the constraint's unit.
double violation(const DroppedConstraint& constraint, const ShootingProblem& problem,
                 const Trajectory& trajectory);

}  // namespace conddp
