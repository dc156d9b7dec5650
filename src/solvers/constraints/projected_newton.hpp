#pragma once

#include <memory>
#include <vector>

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/common/iteration_record.hpp"
#include "solvers/constraints/active_rows.hpp"
#include "solvers/riccati/adjoint.hpp"
#include "solvers/riccati/backward_sweep.hpp"
#include "solvers/stages/stage_solver.hpp"

namespace conddp {

/// What decides whether an iterate of the projected Newton method is a solution.
struct KktNorms {
  Extremum stationarity;  ///< ‖∇_u L‖∞ without the controls held at a bound
  Extremum gap;
  Extremum violation;          ///< of constraints and control bounds, active or not
  double complementarity = 0;  ///< largest complementarity() of the constraints
  double largest() const;
};

/// Newton's method on the optimality conditions of the whole trajectory: gaps, active constraints
/// and the gradient of the Lagrangian, whose exact Hessian it uses. States and controls move
/// together; the gaps are unknowns like the rest. Where exact Hessians are dear, steps keep the one
/// they have while each lowers the largest norm to a tenth.
///
/// Which constraints and control bounds are active is found anew at each iterate and revised by its
/// step (ActiveRows), until the step is the solution of the quadratic problem with inequalities.
///
/// The step is the solution of the equality-constrained quadratic problem of the horizon, by the
/// proximal method of multipliers: a Riccati sweep with the active rows as penalties, then sweeps
/// with corrected multipliers until the rows hold, all with one Hessian. Redundant rows do no harm,
/// stages without curvature of their own neither, and the cost is linear in the horizon.
class ProjectedNewton {
 public:
  ProjectedNewton(const ShootingProblem& problem, Evaluator& evaluator);

  /// Starts at a trajectory with multipliers of all constraint rows; `penalty` is ρ, row by row.
  void start(const Trajectory& trajectory, const Eigen::VectorXd& multipliers,
             const Eigen::VectorXd& penalty, const Feedback& feedback);
  /// One step. False, with the iterate unchanged, where none of a few step lengths makes the
  /// largest norm smaller than `growth` times what it was. Growth lets a step through that changes
  /// many active rows at once.
  bool step(double growth = 1);

  const KktNorms& norms() const { return norms_; }
  double step_length() const { return step_length_; }
  /// How many exact Hessians were evaluated since start().
  int exact_hessians() const { return exact_hessians_; }
  int active_rows() const { return rows_.count(); }
  /// Writes what is known of the iterate and the step to it into a row of the log.
  void describe(IterationRecord& row) const;
  double cost() const;
  const Trajectory& trajectory() const { return trajectory_; }
  /// Of all constraint rows.
  const Eigen::VectorXd& multipliers() const { return multipliers_; }
  /// Derivatives of the iterate, whose gradients have the multipliers of active rows.
  const Linearization& linearization() const { return linearization_; }
  /// Its co-states and control gradients, along feedback().
  const Adjoint& adjoint() const { return adjoint_; }
  /// The policy of the last step, which keeps to the active constraints.
  const Feedback& feedback() const { return feedback_; }

 private:
  void linearize();
  void measure();
  bool try_step(double bound);
  bool solve_quadratic();
  double take_hessians();
  void evaluate_exact_hessian();
  bool solve_on_rows(double penalty);
  bool correct_rows(double penalty, double before);
  bool sweep_with(const std::vector<Eigen::MatrixXd>& hessians, double penalty);
  void move();
  bool sweep();

  const ShootingProblem& problem_;
  Evaluator& evaluator_;
  ControlBounds bounds_;
  Linearization linearization_;
  Adjoint adjoint_;
  BackwardSweep sweep_;
  std::unique_ptr<StageSolver> stages_;
  Gaps gaps_;
  ActiveRows rows_;
  Feedback feedback_;
  Trajectory trajectory_, before_;
  Augmentation lagrangian_;  ///< multipliers alone
  Eigen::VectorXd multipliers_, multipliers_before_, target_, penalty_;
  std::vector<Eigen::VectorXd> cost_gradient_;
  std::vector<Eigen::MatrixXd> gauss_newton_, exact_;
  std::vector<Eigen::VectorXd> step_;  ///< z of each node
  Eigen::VectorXd scratch_;
  KktNorms norms_;
  double step_length_ = 0;
  int sweeps_ = 0;      ///< of the last step
  bool dear_;           ///< exact_hessians_are_dear()
  bool keeps_ = false;  ///< the next step takes the exact Hessians of the last one
  int exact_hessians_ = 0;
  bool curved_ = true;  ///< the exact Hessian is another one than Gauss-Newton's
};

}  // namespace conddp
