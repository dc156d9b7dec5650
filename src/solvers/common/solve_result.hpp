#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/common/iteration_record.hpp"
#include "solvers/common/status.hpp"
#include "solvers/common/strategy_record.hpp"

namespace conddp {

/// Norms that decide convergence, and the knots where they are attained (−1: zero everywhere, or
/// unknown). NaN if nothing could be evaluated.
struct Residuals {
  double stationarity = std::numeric_limits<double>::quiet_NaN();
  double gap = std::numeric_limits<double>::quiet_NaN();
  double constraint = std::numeric_limits<double>::quiet_NaN();
  double complementarity = 0;  ///< 0 if projection enforces the bounds
  int stationarity_knot = -1;
  int gap_knot = -1;
  int constraint_knot = -1;
};

/// SolveResult::failed_quantity of a solve that ends because rounding hides changes of its cost.
inline constexpr std::string_view kRoundedCost = "rounding of the cost";

/// Wall-clock seconds, in total and by kind of work.
struct SolveTimes {
  double total = 0;
  double evaluate = 0;       ///< simulation of the guess
  double differentiate = 0;  ///< derivatives, exact Hessians, co-states
  double sweep = 0;          ///< Riccati sweeps and linear rollouts
  double rollout = 0;        ///< line searches
};

/// Answer of a solve with any status: the last finite iterate and all that is known about it.
struct SolveResult {
  explicit SolveResult(const ShootingProblem& problem)
      : trajectory(problem.create_trajectory()),
        feedback(problem),
        costates(Eigen::MatrixXd::Zero(problem.ndx(), problem.knots() + 1)),
        state_gradient(Eigen::MatrixXd::Zero(problem.ndx(), problem.knots() + 1)),
        constraint_values(Eigen::VectorXd::Zero(problem.constraint_rows())),
        constraint_multipliers(constraint_values) {}

  SolveStatus status = SolveStatus::diverged;
  std::string message;          ///< one sentence: the cause, with knot and quantity
  int failed_knot = -1;         ///< knot where the solve failed; −1 for no particular knot
  std::string failed_quantity;  ///< quantity that was not finite or not definite there; may be
                                ///< empty
  std::string start;            ///< one sentence: the parts of the guess that were used
  double cost = std::numeric_limits<double>::quiet_NaN();
  int iterations = 0;
  Residuals residuals;
  SolveTimes times;
  Trajectory trajectory;
  /// Gains of a sweep at `trajectory`; zero if no sweep succeeded there.
  Feedback feedback;
  /// Regularization of that sweep: 0 unless Q_uu needs it. Empty if no sweep succeeded.
  std::optional<double> feedback_regularization;
  /// Adjoint co-states at `trajectory`, ndx x (N + 1). Column k + 1 is the multiplier of f(x_k,
  /// u_k) ⊖ x_{k+1}.
  Eigen::MatrixXd costates;
  /// ∇_x of the Lagrangian at these co-states, ndx x (N + 1): −Kᵀ ∇_u if they follow a policy.
  Eigen::MatrixXd state_gradient;
  /// ∇_u of the Lagrangian without the bounds' terms, by knot. A control at its lower bound has the
  /// multiplier max(0, entry), at its upper bound max(0, −entry).
  std::vector<Eigen::VectorXd> control_gradient;
  /// g and ν of all constraint rows of the problem (ShootingProblem::constraints()); zero for a
  /// constraint that is switched off.
  Eigen::VectorXd constraint_values, constraint_multipliers;
  std::vector<IterationRecord> log;
  /// All solves of a homotopy, in order; empty without a homotopy. Iterations, log and times above
  /// cover all of them together.
  std::vector<HomotopyStep> homotopy;
  /// Attempts of `auto`, in order. Iterations and log above are those of the chosen attempt; the
  /// total time covers all.
  std::vector<Attempt> attempts;
  /// Record of a solve with restarts. Iterations and log above are those of the start whose answer
  /// is returned; the total time covers all.
  std::optional<RestartRecord> restarts;
};

}  // namespace conddp
