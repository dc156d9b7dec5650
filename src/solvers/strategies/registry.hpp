#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "solvers/common/options.hpp"
#include "solvers/common/solve_result.hpp"

namespace conddp {

/// Treatment of control bounds.
enum class BoundSupport {
  exact,    ///< enforces them and converges to a constrained optimum
  clipped,  ///< enforces them by clamping controls, which may end short of an optimum
  none,     ///< does not support them
};

/// Constraints, apart from control bounds, that a solver enforces.
enum class ConstraintSupport { none, equalities, all };

/// A solver of the family: its name, its capabilities, and how to run it.
struct SolverInfo {
  std::string_view name;
  std::string_view description;  ///< one line
  BoundSupport control_bounds = BoundSupport::none;
  ConstraintSupport constraints = ConstraintSupport::none;
  bool complementarity = false;      ///< enforces 0 ≤ z ⊥ s ≥ 0
  bool open_gaps = false;            ///< starts from states that do not follow from the controls
  bool gauss_newton_hessian = true;  ///< can omit second derivatives of the dynamics
  bool exact_hessian = false;        ///< can use second derivatives of the dynamics
  bool concurrent = true;            ///< may run in several threads at once
  bool real_time = true;             ///< has real-time iterations (ReusableSolver::iterate)
  /// The solver alone. Its status `infeasible` is a suspicion, which solve() examines.
  std::function<SolveResult(const ShootingProblem&, const SolverOptions&, const Trajectory& guess)>
      run = {};
};

/// All solvers, in the order of the documentation.
std::span<const SolverInfo> solvers();
/// Solver of this name, or null.
const SolverInfo* find_solver(std::string_view name);
/// Names of the constraints, apart from control bounds, that the solver does not support, each
/// once, in the order of the nodes.
std::vector<std::string> unsupported_constraints(const SolverInfo& solver,
                                                 const ShootingProblem& problem);
/// Reason why the solver does not support the problem: the constraint, and the solvers that do.
/// Empty if it does.
std::optional<std::string> unsupported(const SolverInfo& solver, const ShootingProblem& problem);

/// Reason why the solver lacks the chosen Hessian of the dynamics. Empty if it has it.
std::optional<std::string> unsupported_hessian(const SolverInfo& solver, HessianChoice choice);

/// Leaves the choice to the problem.
inline constexpr std::string_view kAutoSolver = "auto";
/// Solvers that `auto` tries, in order: ipddp and ipopt with complementary pairs; altro, proxddp
/// and ipopt with constraints other than control bounds; otherwise box_fddp and ipopt. Omits
/// solvers that do not support the requested Hessian.
std::vector<const SolverInfo*> auto_solvers(const ShootingProblem& problem,
                                            const SolverOptions& options);

using SolverList = std::span<const SolverInfo* const>;
/// Names the first solver of `auto`, the reason, and the solvers that follow: "altro, since there
/// are constraints besides bounds on the control; then proxddp, ipopt".
std::string describe_auto(const ShootingProblem& problem, SolverList list);

/// Solves a problem from a guess, along a homotopy and with restarts if the options request them.
/// Throws std::invalid_argument if the options are not valid, if the solver does not support the
/// problem or the requested Hessian, or if the guess has another shape. Every other end is a
/// status.
SolveResult solve(const ShootingProblem& problem, const SolverInfo& solver,
                  const SolverOptions& options, const Trajectory& guess);
/// Objection to a converged answer.
struct Objection {
  std::string text;         ///< empty without an objection
  bool jumps = false;       ///< the motion leads through a region that it should go around
  bool of_problem = false;  ///< redundant constraints cause it, whatever the solver
  double excess = 0;  ///< remaining gain as a multiple of the allowed one; 0 if this is not the
                      ///< objection
  /// At a saddle: (δx, δu) of each node, along which the cost falls. Otherwise empty.
  std::vector<Eigen::VectorXd> descent;
};
/// Finds an objection. May be called from several threads.
using Doubt = std::function<Objection(const ShootingProblem&, const SolveResult&)>;
/// Solves with the first of these solvers whose answer converges without objections
/// (solve_answering), all within one time limit; a null `doubt` never objects. If all of several
/// solvers fail, the first of them solves from up to 20 other guesses, without a homotopy;
/// otherwise the answer of the first is returned. An end by a limit or a signal is final. `used`
/// receives the solver of the answer. Initial multipliers go to the solvers that accept them.
/// Throws std::invalid_argument without candidates.
SolveResult solve(const ShootingProblem& problem, SolverList candidates,
                  const SolverOptions& options, const Trajectory& guess, const SolverInfo*& used,
                  const Doubt& doubt = nullptr);
/// The same; if the answer came soon, returns the best of further ones (look_further).
SolveResult solve_best(const ShootingProblem& problem, SolverList candidates,
                       const SolverOptions& options, const Trajectory& guess,
                       const SolverInfo*& used, const Doubt& doubt);
/// The same by name, including `auto`. Throws std::invalid_argument for an unknown name.
SolveResult solve(const ShootingProblem& problem, std::string_view solver,
                  const SolverOptions& options, const Trajectory& guess);

/// Throws std::invalid_argument if the options are not valid, or the solver does not support the
/// problem or the requested Hessian or multipliers.
void check_options(const SolverInfo& solver, const ShootingProblem& problem,
                   const SolverOptions& options);

}  // namespace conddp
