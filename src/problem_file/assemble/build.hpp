#pragma once

#include <memory>
#include <string>
#include <vector>

#include "problem_file/assemble/guess_builder.hpp"
#include "problem_file/assemble/phase_builder.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {

struct BuildOptions {
  /// Names of constraints to leave out.
  std::vector<std::string> drop;
  /// Plant built before from the same robots or system; if null, it is built.
  const Plant* plant = nullptr;
  /// Former solution (solution.json or a CSV file) that replaces the guess of the file, with its
  /// multipliers if it has them. Its path is relative to the current folder.
  std::optional<Located<std::filesystem::path>> start = {};
  bool default_guess = false;    ///< replaces that of the file
  bool unperturbed = false;      ///< leaves out the perturbation of the file
  bool unplaced_solver = false;  ///< the file does not name the solver: messages have no place
};

/// A dropped constraint, kept so that its violation can be reported.
struct DroppedConstraint {
  std::string name;
  std::optional<PhaseBounds> bounds;             ///< for bounds on the control
  std::shared_ptr<const ShootingProblem> alone;  ///< otherwise: a problem with only this constraint
};

class Homotopy;

/// A problem ready to solve.
struct BuiltProblem {
  std::shared_ptr<const ProblemSpec> problem_spec;  ///< for `problem_file` alone
  Plant plant;
  std::shared_ptr<const ShootingProblem> problem;
  std::vector<Column> state_columns;  ///< including augmented states
  int integrals = 0;                  ///< number of integrals, after the system's states
  /// Linear controls at the nodes are states. The controls here are those at the ends of knots,
  /// with the prefix kEndOfKnot.
  std::vector<Column> control_columns;
  Trajectory guess;
  GuessUsed guess_used;
  std::shared_ptr<const DualGuess> multipliers;     ///< initial multipliers, or null
  std::shared_ptr<const Homotopy> homotopy;         ///< homotopy of the file, or null
  std::shared_ptr<const TerminalLqr> terminal_lqr;  ///< from `terminal: {lqr: ...}`, or null
  std::vector<DroppedConstraint> dropped;
  /// A problem whose constraint values are the numbers of the file's drawings, see
  /// drawing_builder.hpp, or null.
  std::shared_ptr<const ShootingProblem> drawn;
  std::vector<InputFile> data_files;  ///< read for references and the guess

  const ProblemFacts& facts() const { return *problem_spec; }
};

/// Builds the problem of a spec, at the end of its homotopy if it has one. Reports unknown names of
/// frames, joints, phases, solvers and so on with their places and similar names.
std::optional<BuiltProblem> build_without_homotopy(ProblemSpec spec, const BuildOptions& options,
                                                   Diagnostics& out);

/// The solver named by the file, or the solvers that `auto` tries, in order. Empty if none supports
/// the problem; the reason is reported.
std::vector<const SolverInfo*> usable_solvers(const BuiltProblem& built, Diagnostics& out);

/// Names of all constraints, which can be dropped individually.
std::vector<std::string> constraint_names(const BuiltProblem& built);

/// Integrator of systems whose problem file does not name one.
Integrator default_integrator(SystemKind kind);

/// Names of the tangent coordinates of states, including augmented states.
std::vector<std::string> tangent_columns(const BuiltProblem& built);

/// Largest violation of a dropped constraint by a trajectory, in the constraint's unit.
double violation(const DroppedConstraint& constraint, const ShootingProblem& problem,
                 const Trajectory& trajectory);

}  // namespace conddp
