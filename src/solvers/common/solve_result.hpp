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

/// The norms that decide convergence, and the knots at which they are attained (−1: zero
/// everywhere, or not known). Not-a-number where nothing could be evaluated.
struct Residuals {
  double stationarity = std::numeric_limits<double>::quiet_NaN();
  double gap = std::numeric_limits<double>::quiet_NaN();
  double constraint = std::numeric_limits<double>::quiet_NaN();
  double complementarity = 0;  ///< 0 where bounds are kept by projection
  int stationarity_knot = -1;
  int gap_knot = -1;
  int constraint_knot = -1;
};

/// SolveResult::failed_quantity of a solve that ends because its cost has no more digits.
inline constexpr std::string_view kRoundedCost = "rounding of the cost";

/// Wall-clock seconds, in all and by act.
struct SolveTimes {
  double total = 0;
  double evaluate = 0;       ///< simulating the guess
  double differentiate = 0;  ///< derivatives, exact Hessians, co-states
  double sweep = 0;          ///< Riccati sweeps and linear rollouts
  double rollout = 0;        ///< line searches
};

/// The answer of a solve, whatever its status: the last finite iterate and what is known about it.
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
  int failed_knot = -1;         ///< where the solve failed, −1: at no knot in particular
  std::string failed_quantity;  ///< what was not finite or not definite there, may be empty
  std::string start;            ///< one sentence: what of the guess was used
  double cost = std::numeric_limits<double>::quiet_NaN();
  int iterations = 0;
  Residuals residuals;
  SolveTimes times;
  Trajectory trajectory;
  /// Of a sweep at `trajectory`; zero where no sweep succeeded there.
  Feedback feedback;
  /// Regularisation of that sweep: 0 but where Q_uu needs it. Empty where none succeeded.
  std::optional<double> feedback_regularization;
  /// Adjoint co-states at `trajectory`, ndx x (N + 1): multipliers of f(x_k, u_k) ⊖ x_{k+1} are the
  /// columns k + 1.
  Eigen::MatrixXd costates;
  /// ∇_x of the Lagrangian at these co-states, ndx x (N + 1): −Kᵀ ∇_u where they follow a policy.
  Eigen::MatrixXd state_gradient;
  /// ∇_u of the Lagrangian without the bounds' terms, one a knot: a control at its lower bound has
  /// the multiplier max(0, entry), at its upper bound max(0, −entry).
  std::vector<Eigen::VectorXd> control_gradient;
  /// g and ν of all constraint rows of the problem (ShootingProblem::constraints()); zero where a
  /// constraint is switched off.
  Eigen::VectorXd constraint_values, constraint_multipliers;
  std::vector<IterationRecord> log;
  /// All solves of a homotopy, in order; empty without one. Iterations, log and times above are
  /// those of all of them together.
  std::vector<HomotopyStep> homotopy;
  /// What `auto` tried, in order. Iterations and log above are those of the chosen one, the total
  /// time is that of all.
  std::vector<Attempt> attempts;
  /// Of a solve with restarts. Iterations and log above are those of the start whose answer counts,
  /// the total time is that of all.
  std::optional<RestartRecord> restarts;
};

}  // namespace conddp
