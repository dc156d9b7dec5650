#pragma once

#include <string>
#include <vector>

#include "ocp/evaluation/linearization.hpp"
#include "ocp/problem/problem.hpp"
#include "solvers/common/control_bounds.hpp"
#include "solvers/common/options.hpp"
#include "solvers/iterate/control_curvature.hpp"
#include "solvers/iterate/ddp_recipe.hpp"

namespace conddp {

/// Measures of how well the constraints hold at an iterate.
struct ConstraintNorms {
  Extremum violation;          ///< largest distance from a set
  double complementarity = 0;  ///< largest complementarity()
  double dual_gain = 0;  ///< Σ |ν⁺ − ν|²/ρ: gain of the dual function by ν⁺, to first order
};

/// Multipliers and penalties of all constraints, and their updates between the minimizations of the
/// augmented Lagrangian (Howell, Jackson, Manchester 2019; cones as in Jackson et al. 2021).
///
/// The multipliers of values g are ν⁺ = ρ (g + ν/ρ − Π_C(g + ν/ρ)), which is a projection by
/// definition: the gradient of the augmented Lagrangian at ν is that of the Lagrangian at ν⁺. The
/// augmented Lagrangian has a continuous gradient wherever a constraint becomes active, so that
/// line searches see no jump. Each constraint, identified by its name, has its own penalty.
class AugmentedLagrangian {
 public:
  AugmentedLagrangian(const ShootingProblem& problem, const SolverOptions& options,
                      MultiplierSchedule schedule);

  /// Sets the multipliers (one per constraint row of the problem) and the first penalties.
  void start(const Eigen::VectorXd& multipliers);

  /// Lowers the first penalties of soft constraints according to the values of the first iterate.
  /// Violations ten times as large then stay within the limits of the multipliers. Beyond these
  /// limits the penalty lacks curvature, and a step notices the kink only after crossing it. To be
  /// called after start(). True if a penalty is now lower.
  bool fit_soft(const Eigen::VectorXd& values);

  /// Lowers the first penalties of constraints on controls to a multiple of the costs' curvature in
  /// these controls, as seen by the constraint's rows. A penalty many orders of magnitude above it
  /// turns the whole optimum of the cost into edges, where active sets do not settle. To be called
  /// after start(). True if a penalty is now lower.
  bool fit_to_costs(const Linearization& linearization);

  const Augmentation& augmentation() const { return augmentation_; }
  /// Takes the values of an iterate and computes their ν⁺.
  ConstraintNorms measure(const Eigen::VectorXd& values);
  /// True if all shifted values lie strictly inside their sets. The constraints then contribute
  /// nothing to the cost or its derivatives.
  bool idle(const Eigen::VectorXd& values);
  /// ν⁺ of the last measure().
  const Eigen::VectorXd& multipliers() const { return next_; }

  /// Ends a minimization: ν ← ν⁺, and penalties grow according to the schedule. No penalty grows
  /// after an incomplete minimization.
  void update(bool minimized = true);
  /// ν ← the multipliers of the last measure(). Penalties stay.
  void take_multipliers() { adopt(next_); }
  /// ν ← ν + step · change, for sweeps that find multipliers.
  void add(const Eigen::VectorXd& change, double step);
  /// Lowers the penalties if the multipliers hold the constraints without them.
  void relax();
  /// True if a penalty is above its first value.
  bool may_relax() const;
  /// Takes multipliers from another source; penalties stay.
  void adopt(const Eigen::VectorXd& multipliers);
  /// Name of a constraint that does not respond to penalties, or empty. Its violation, above
  /// tolerance, has not halved while its penalty grew six times, or would have grown beyond its
  /// limit.
  const std::string& stalled() const { return stalled_; }
  double largest_penalty() const;

 private:
  /// Nodes of a constraint and its current state.
  struct Group {
    std::string name;
    std::vector<int> constraints;  ///< indices into ShootingProblem::constraints()
    bool soft = false;
    double first_penalty = 0;
    double penalty = 0;
    double violation = 0;  ///< at the last measure(); equal to `change` if soft
    double before = 0;     ///< the same at the last update()
    double change = 0;     ///< at the last measure(): largest |ν⁺ − ν|/ρ
    double allowed = 0;    ///< largest `change` that updates ν
    double reference = 0;  ///< violation that has to halve
    int growths = 0;       ///< number of penalty growths since then
  };
  void take_multipliers(const Group& group);
  bool grows_after_update(const Group& group) const;
  bool grows_instead_of_update(Group& group);
  void watch_progress(Group& group, bool grown);
  bool stays_violated(const Group& group) const;
  bool is_idle(const NodeConstraint& c, const Eigen::VectorXd& values) const;
  void write(const Group& group);

  const ShootingProblem& problem_;
  SolverOptions::AugmentedLagrangian options_;
  double tolerance_;
  MultiplierSchedule schedule_;
  ControlCurvature control_curvature_;
  std::vector<Group> groups_;
  Augmentation augmentation_;
  Eigen::VectorXd multipliers_, next_;
  Eigen::VectorXd shifted_;  ///< of all rows, or of one constraint
  std::string stalled_;
};

}  // namespace conddp
