#pragma once

#include <string>
#include <vector>

#include "ocp/evaluation/linearization.hpp"
#include "ocp/problem/augmentation.hpp"
#include "solvers/common/control_bounds.hpp"
#include "solvers/common/options.hpp"
#include "solvers/iterate/control_curvature.hpp"
#include "solvers/iterate/ddp_recipe.hpp"

namespace conddp {

/// How well the constraints hold at an iterate.
struct ConstraintNorms {
  Extremum violation;          ///< largest distance from a set
  double complementarity = 0;  ///< largest complementarity()
  double dual_gain = 0;  ///< Σ |ν⁺ − ν|²/ρ: what ν⁺ raises the dual function by, to first order
};

/// Multipliers and penalties of all constraints, and how they change between the minimisations of
/// the augmented Lagrangian (Howell, Jackson, Manchester 2019; cones as in Jackson et al. 2021).
///
/// The multipliers that belong to values g are ν⁺ = ρ (g + ν/ρ − Π_C(g + ν/ρ)), projected by their
/// definition: the gradient of the augmented Lagrangian at ν is that of the Lagrangian at ν⁺. The
/// augmented Lagrangian has a continuous gradient wherever a constraint becomes active, so that
/// line searches see no jump. Each constraint, by name, has its penalty.
class AugmentedLagrangian {
 public:
  AugmentedLagrangian(const ShootingProblem& problem, const SolverOptions& options,
                      MultiplierSchedule schedule);

  /// Multipliers (a number per constraint row of the problem) and first penalties.
  void start(const Eigen::VectorXd& multipliers);

  /// Lowers the first penalties of soft constraints, by the values of the first iterate, as far as
  /// those may be missed ten times over within the limits of the multipliers: beyond them the
  /// penalty has no curvature, and steps know of a kink only when they have crossed it. Returns
  /// whether one is lower now. After start().
  bool fit_soft(const Eigen::VectorXd& values);

  /// Lowers the first penalties of constraints on controls to so many times the curvature that the
  /// costs have in these, seen by the constraint's rows: a penalty many orders above makes edges of
  /// all the cost's optimum, on which active sets do not settle. Returns whether one is lower now.
  /// After start().
  bool fit_to_costs(const Linearization& linearization);

  const Augmentation& augmentation() const { return augmentation_; }
  /// Takes the values of an iterate and computes ν⁺ of them.
  ConstraintNorms measure(const Eigen::VectorXd& values);
  /// Whether all values lie strictly inside of their sets, shifted as they are: then the
  /// constraints add nothing to the cost, nor to its derivatives.
  bool idle(const Eigen::VectorXd& values);
  /// ν⁺ of the last measure.
  const Eigen::VectorXd& multipliers() const { return next_; }

  /// Ends one minimisation: ν ← ν⁺ and penalties grow as the schedule has it; no penalty grows
  /// where the minimisation was not one.
  void update(bool minimized = true);
  /// ν ← ν + step · change, where sweeps find multipliers.
  void add(const Eigen::VectorXd& change, double step);
  /// Penalties fall, where multipliers hold the constraints without them.
  void relax();
  /// Whether there is one that is not its first penalty.
  bool may_relax() const;
  /// Takes multipliers that were found otherwise; penalties stay.
  void adopt(const Eigen::VectorXd& multipliers);
  /// A constraint for which penalties do not help: its violation, above tolerance, has not halved
  /// while its penalty grew six times, or would have beyond its limit. Empty if there is none.
  const std::string& stalled() const { return stalled_; }
  double largest_penalty() const;

 private:
  /// A constraint's nodes and what has become of it.
  struct Group {
    std::string name;
    std::vector<int> constraints;  ///< into ShootingProblem::constraints()
    bool soft = false;
    double first_penalty = 0;
    double penalty = 0;
    double violation = 0;  ///< at the last measure; of a soft one `change`
    double before = 0;     ///< the same at the last update
    double change = 0;     ///< at the last measure: largest |ν⁺ − ν|/ρ
    double allowed = 0;    ///< what that may be for ν to change
    double reference = 0;  ///< violation since whose half
    int growths = 0;       ///< the penalty has grown this often
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
