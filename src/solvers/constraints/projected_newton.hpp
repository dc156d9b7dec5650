#pragma once

#include <vector>

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/common/iteration_record.hpp"
#include "solvers/common/solve_record.hpp"
#include "solvers/constraints/horizon_qp.hpp"
#include "solvers/constraints/outer_strategy.hpp"
#include "solvers/iterate/iterate.hpp"
#include "solvers/riccati/adjoint.hpp"

namespace conddp {

/// Norms that decide whether an iterate of the projected Newton method is a solution.
struct KktNorms {
  Extremum stationarity;  ///< ‖∇_u L‖∞ without the controls held at a bound
  Extremum gap;
  Extremum violation;          ///< of constraints and control bounds, active or not
  double complementarity = 0;  ///< largest complementarity() of the constraints
  double largest() const;
};

/// Newton's method on the optimality conditions of the whole trajectory: gaps, active constraints
/// and the gradient of the Lagrangian, with its exact Hessian. States and controls move together,
/// and gaps are treated like the other residuals. If exact Hessians are expensive, steps reuse the
/// last one while each reduces the largest norm to a tenth.
///
/// Each step solves the horizon QP (HorizonQp::satisfy) with one Hessian, starting from the rows
/// and control bounds that are active at the iterate. Redundant rows and stages without curvature
/// of their own are harmless, and the computing time is linear in the horizon.
class ProjectedNewton {
 public:
  ProjectedNewton(const ShootingProblem& problem, Evaluator& evaluator);

  /// Starts at a trajectory with multipliers of all constraint rows; `penalty` is ρ, row by row.
  void start(const Trajectory& trajectory, const Eigen::VectorXd& multipliers,
             const Eigen::VectorXd& penalty, const Feedback& feedback);
  /// Takes one step. False, with the iterate unchanged, if none of a few step lengths reduces the
  /// largest norm below `growth` times its previous value. Growth admits a step that changes many
  /// active rows at once.
  bool step(double growth = 1);

  /// Writes the iterate with its residuals, gains, co-states and multipliers into a result.
  void write_answer(SolveResult& result) const;
  const KktNorms& norms() const { return norms_; }
  double step_length() const { return step_length_; }
  /// Number of exact Hessians evaluated since start().
  int exact_hessians() const { return exact_hessians_; }
  /// Number of active constraint rows and held controls.
  int active_rows() const { return active_rows_; }
  /// Writes the data of the iterate, and of the step that led to it, into a row of the log.
  void describe(IterationRecord& row) const;
  double cost() const;
  const Trajectory& trajectory() const { return trajectory_; }
  /// Multipliers of all constraint rows.
  const Eigen::VectorXd& multipliers() const { return multipliers_; }
  /// Derivatives of the iterate; the gradients include the multipliers of active rows.
  const Linearization& linearization() const { return linearization_; }
  /// Co-states and control gradients of the iterate, along feedback().
  const Adjoint& adjoint() const { return adjoint_; }
  /// The policy of the last step, which respects the active constraints.
  const Feedback& feedback() const { return qp_.feedback(); }

 private:
  void linearize();
  int held_controls() const;
  void measure();
  bool try_step(double bound);
  bool solve_quadratic();
  double take_hessians();
  void evaluate_exact_hessian();
  bool solve_with(const std::vector<Eigen::MatrixXd>& hessians, double penalty);
  void move();

  const ShootingProblem& problem_;
  Evaluator& evaluator_;
  ControlBounds bounds_;
  Linearization linearization_;
  Adjoint adjoint_;
  Gaps gaps_;
  HorizonQp qp_;
  Trajectory trajectory_, before_;
  Augmentation lagrangian_;  ///< multipliers only
  Eigen::VectorXd multipliers_;
  Eigen::VectorXd given_, given_before_;  ///< multipliers before the choice of active rows
  Eigen::VectorXd multipliers_before_, target_, penalty_;
  std::vector<Eigen::VectorXd> cost_gradient_;
  std::vector<Eigen::MatrixXd> gauss_newton_, exact_;
  KktNorms norms_;
  double step_length_ = 0;
  int active_rows_ = 0;
  int sweeps_ = 0;      ///< of the last step
  bool dear_;           ///< exact_hessians_are_dear()
  bool keeps_ = false;  ///< the next step reuses the exact Hessians of the last one
  int exact_hessians_ = 0;
  bool curved_ = true;  ///< the exact Hessian differs from Gauss-Newton's
};

/// Ends a solve by Newton's method on the active constraints. Its steps are iterations.
class NewtonPolish {
 public:
  NewtonPolish(const ShootingProblem& problem, Evaluator& evaluator, const SolverOptions& options);

  /// Prepares a solve.
  void reset();
  /// True if an iterate is near enough to a solution for a try.
  bool due(const IterationRecord& row) const;
  /// Takes Newton steps from an iterate. If they meet the tolerances of stationarity, gap and
  /// violation, the iterate becomes Newton's, with its multipliers, but is not linearized yet.
  /// Otherwise the result is false and the iterate stays; the next try waits until it is much
  /// nearer.
  bool run(Iterate& iterate, const Feedback& feedback, OuterStrategy& outer, SolveRecord& record);
  /// The policy of the last step, which respects the active constraints.
  const Feedback& feedback() const { return newton_.feedback(); }

 private:
  void iterate_newton(SolveRecord& record);

  ProjectedNewton newton_;
  const SolverOptions& options_;
  double threshold_ = 0;  ///< violation, gap and stationarity below which a try is due
};

}  // namespace conddp
