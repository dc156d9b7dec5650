#pragma once

#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "ocp/knot/knot_model.hpp"
#include "ocp/problem/trajectory.hpp"

namespace conddp {

/// A run of knots that share their structure and differ in data.
struct Phase {
  std::string name;
  std::shared_ptr<const KnotModel> model;
  std::vector<double> dt;          ///< s, one per knot
  std::vector<double> cost_scale;  ///< factor on the running costs, usually dt
  std::vector<double> parameters;  ///< parameter_count() numbers per knot, knot after knot
  bool instant = false;            ///< takes no time, even if the integrator's dt is not zero

  int knots() const { return static_cast<int>(dt.size()); }
};

/// One knot of a problem: its structure and pointers to its data.
struct KnotView {
  const KnotModel* model;
  const double* parameters;
  double dt;
  double cost_scale;
  int phase;
};

/// The numerical data of one knot.
struct KnotNumbers {
  double dt;
  double cost_scale;
  const double* parameters;  ///< parameter_count() numbers of the knot's model
};

/// A constraint at one node that is not switched off.
struct NodeConstraint {
  int node;
  const ConstraintTerm* term;
  int row;              ///< first row among the constraint rows of the problem
  const double* lower;  ///< term->rows numbers, like `upper`; null for a cone
  const double* upper;
  /// Upper limit on the multipliers of an l1-soft constraint: row by row, or on the norm for a
  /// cone.
  double limit = std::numeric_limits<double>::infinity();

  bool is_soft() const { return term->softness != Softness::hard; }
};

/// Times of all nodes for steps of these lengths, starting at 0: one more than there are steps.
/// Fifty steps of 0.06 s end at 3, not at 3.000000000000002.
std::vector<double> node_times(std::span<const double> steps);

/// An optimal-control problem as a list of phases, an initial state and a terminal node:
/// minimize Σ cost_scale·ℓ(x_k, u_k) + ℓ_N(x_N) subject to x_{k+1} = f(x_k, u_k), x_0 given, lower
/// ≤ u_k ≤ upper, and the values g of all constraints in their sets.
class ShootingProblem {
 public:
  /// The terminal phase has one knot, whose model has Integrator::none. All models share nx. Throws
  /// std::invalid_argument if sizes do not match.
  ShootingProblem(std::vector<double> initial_state, std::vector<Phase> phases, Phase terminal);
  ShootingProblem(ShootingProblem&&) = default;  // views remain valid: vector buffers do not move
  ShootingProblem(const ShootingProblem&) = delete;

  const std::vector<Phase>& phases() const { return phases_; }
  const Phase& terminal() const { return terminal_; }
  const std::vector<double>& initial_state() const { return initial_state_; }
  /// Sets the initial state between solves of one problem, never during a solve. Throws
  /// std::invalid_argument if `x` does not have nx numbers.
  void set_initial_state(std::span<const double> x);
  /// Replaces the numerical data of all N + 1 nodes between solves, never during a solve, without
  /// allocation. The structure must not change: which constraints are switched off, which weights
  /// are zero, and which knots take no time.
  void set_numbers(std::span<const KnotNumbers> nodes);

  /// Number N of running knots; knot(N) is the terminal node.
  int knots() const { return static_cast<int>(views_.size()) - 1; }
  const KnotView& knot(int k) const { return views_[k]; }
  int nx() const { return views_.front().model->nx(); }
  int ndx() const { return views_.front().model->ndx(); }
  int nu(int k) const { return views_[k].model->nu(); }
  const StateManifold& manifold() const { return views_.front().model->manifold(); }
  /// Time of each node, s: N + 1 numbers.
  const std::vector<double>& times() const { return times_; }
  /// Node times of a trajectory, whose states contain the free durations (FreeDuration).
  std::vector<double> times(const Trajectory& trajectory) const;
  bool has_free_durations() const;
  bool has_control_bounds() const;
  /// True if a running knot takes no time: an impulse, or an instantaneous phase.
  bool takes_no_time(int k) const { return times_[k] == times_[k + 1]; }
  /// Constraints of all nodes in order, without control bounds and without l2-soft constraints,
  /// which are costs. Views into this problem.
  const std::vector<NodeConstraint>& constraints() const { return constraints_; }
  /// All soft constraints in order.
  const std::vector<NodeConstraint>& soft_constraints() const { return soft_constraints_; }
  /// First constraint row of a node among those of the problem, counting unused rows.
  int constraint_offset(int k) const { return constraint_offset_[k]; }
  int constraint_rows() const { return constraint_offset_.back(); }

  /// A trajectory of this problem's shape: all states equal the initial state, controls are zero.
  Trajectory create_trajectory() const;

 private:
  void add_knots(const Phase& phase, int index);
  void set_numbers(Phase& phase, int first, std::span<const KnotNumbers> nodes);
  void add_constraints(int node);

  std::vector<double> initial_state_;
  std::vector<Phase> phases_;
  Phase terminal_;
  std::vector<KnotView> views_;
  std::vector<double> times_;
  std::vector<NodeConstraint> constraints_, soft_constraints_;
  std::vector<int> constraint_offset_;
};

/// Augmentation of the cost by the constraints: one number each per constraint row of the problem
/// (ShootingProblem::constraint_offset). With values g in sets C, the evaluation adds
///   Σ ½ penalty · dist²(g + shift, C) + Σ multiplierᵀ g;
/// its derivative by g is the multiplier ν = penalty · (g + shift − Π_C(g + shift)) + multiplier.
/// With shift = ν/penalty it is the augmented Lagrangian up to a constant; with penalty 0 it is the
/// Lagrangian. All rows of a cone share one penalty.
struct Augmentation {
  explicit Augmentation(const ShootingProblem& problem)
      : penalty(Eigen::VectorXd::Zero(problem.constraint_rows())),
        shift(penalty),
        multiplier(penalty) {}

  Eigen::VectorXd penalty, shift, multiplier;
};

/// New multipliers from s = g + ν/ρ for values g and the augmented Lagrangian with penalty ρ and
/// multipliers ν: ρ (s − Π(s)), limited for soft constraints. Both arrays have c.term->rows
/// numbers.
void next_multipliers(const NodeConstraint& c, const double* s, double penalty, double* next);

/// Violation of a constraint by g: 0 if soft, else distance_to_set.
double violation(const NodeConstraint& c, const double* g);
/// Complementarity of the term. For a soft constraint outside its set: the distance times the
/// amount by which the multipliers fall short of their limit.
double complementarity(const NodeConstraint& c, const double* g, const double* multipliers);

/// Cost of all l1-soft constraints, from the values of all rows. An evaluation counts l2-soft
/// constraints as costs.
double linear_soft_cost(const ShootingProblem& problem, const Eigen::VectorXd& values);

}  // namespace conddp
