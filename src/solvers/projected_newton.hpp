#pragma once

#include <memory>
#include <vector>

#include "ocp/acts.hpp"
#include "solvers/adjoint.hpp"
#include "solvers/backward_sweep.hpp"
#include "solvers/iteration_record.hpp"
#include "solvers/stage_policy.hpp"

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
/// together; the gaps are unknowns like the rest.
///
/// Active are equalities, rows of inequalities and bounds on the control at which value plus
/// multiplier/ρ lies outside of the set, and cones on whose surface (one row, with the surface's
/// curvature) or tip (all rows) the point nearest to that lies. The set is found anew at each
/// iterate.
///
/// The step is the solution of the equality-constrained quadratic problem of the horizon, by the
/// proximal method of multipliers: a Riccati sweep with the active rows as penalties, then sweeps
/// with corrected multipliers until the rows hold, all with one Hessian. Redundant rows do no harm,
/// stages without curvature of their own neither, and the cost is linear in the horizon.
class ProjectedNewton {
 public:
  ProjectedNewton(const ShootingProblem& problem, Acts& acts);

  /// Starts at a trajectory with multipliers of all constraint rows; `penalty` is ρ, row by row.
  void start(const Trajectory& trajectory, const Eigen::VectorXd& multipliers,
             const Eigen::VectorXd& penalty, const Feedback& feedback);
  /// One step. False, with the iterate unchanged, where none of a few step lengths makes the
  /// largest norm smaller than `growth` times what it was. Growth lets a step through that changes
  /// many active rows at once.
  bool step(double growth = 1);

  const KktNorms& norms() const { return norms_; }
  double step_length() const { return step_length_; }
  int active_rows() const;
  /// Writes what is known of the iterate and the step to it into a row of the log.
  void describe(IterationRecord& row) const;
  double cost() const { return linearization_.total_cost(); }
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
  /// The active rows of a node: value + A z = 0 to first order.
  struct Rows {
    Eigen::MatrixXd A;  ///< rows x nz, the first `count` in use, as of the others
    Eigen::VectorXd value, multiplier;
    Eigen::VectorXd correction;  ///< what the step adds to the multiplier
    std::vector<int> source;     ///< constraint row of the problem (a cone's first), or control
    std::vector<int> kind;
    int count = 0;
  };
  void linearize();
  void find_active(int node);
  void add_cone(const NodeConstraint& constraint, const Eigen::Ref<const Eigen::MatrixXd>& C,
                Rows& rows);
  void add_controls(int node);
  void measure();
  bool solve_quadratic();
  void add_curvature(int node, double penalty);
  double correct(double penalty, bool first);
  bool sweep();
  void set_target();

  const ShootingProblem& problem_;
  Acts& acts_;
  ControlBounds bounds_;
  Linearization linearization_;
  Adjoint adjoint_;
  BackwardSweep sweep_;
  std::unique_ptr<StagePolicy> policy_;
  Gaps gaps_;
  Feedback feedback_;
  Trajectory trajectory_, before_;
  Augmentation lagrangian_;  ///< multipliers alone
  Eigen::VectorXd multipliers_, multipliers_before_, target_, penalty_;
  std::vector<Rows> rows_;                        ///< per node
  std::vector<std::vector<int>> constraints_of_;  ///< node, into problem.constraints()
  std::vector<Eigen::MatrixXd> gauss_newton_;
  std::vector<Eigen::VectorXd> step_;  ///< z of each node
  Eigen::VectorXd z_, scratch_;
  KktNorms norms_;
  double step_length_ = 0;
};

}  // namespace conddp
