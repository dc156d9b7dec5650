#pragma once

#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "ocp/knot/knot_model.hpp"
#include "ocp/problem/trajectory.hpp"

namespace conddp {

/// A run of knots that share their structure and differ in data.
struct Phase {
  std::string name;
  std::shared_ptr<const KnotModel> model;
  std::vector<double> dt;          ///< s, one a knot
  std::vector<double> cost_scale;  ///< what running costs are multiplied by: usually dt
  std::vector<double> parameters;  ///< parameter_count() numbers a knot, knot after knot
  bool instant = false;            ///< takes no time, whatever dt is to the integrator

  int knots() const { return static_cast<int>(dt.size()); }
};

/// One knot of a problem: its structure and where its data lie.
struct KnotView {
  const KnotModel* model;
  const double* parameters;
  double dt;
  double cost_scale;
  int phase;
};

/// The numbers of a knot alone.
struct KnotNumbers {
  double dt;
  double cost_scale;
  const double* parameters;  ///< parameter_count() of the knot's model
};

/// A constraint at one node, where it is not switched off.
struct NodeConstraint {
  int node;
  const ConstraintTerm* term;
  int row;              ///< its first one among the constraint rows of the problem
  const double* lower;  ///< term->rows numbers, as `upper`; null of a cone
  const double* upper;
  /// Of one that is soft by its distance what its multipliers cannot exceed: row by row, of a cone
  /// their norm.
  double limit = std::numeric_limits<double>::infinity();

  bool is_soft() const { return term->softness != Softness::hard; }
};

/// Times of the nodes before, between and after steps of these lengths, from 0 on: one more than
/// there are steps. Fifty steps of 0.06 s end at 3, not at 3.000000000000002.
std::vector<double> node_times(std::span<const double> steps);

/// An optimal-control problem as a list of phases, an initial state and a terminal node.
/// Minimise Σ cost_scale·ℓ(x_k, u_k) + ℓ_N(x_N) with x_{k+1} = f(x_k, u_k), x_0 given,
/// lower ≤ u_k ≤ upper, and the values g of all constraints in their sets.
class ShootingProblem {
 public:
  /// The terminal phase has one knot whose model has Integrator::none. All models share nx.
  /// Throws std::invalid_argument where sizes do not fit.
  ShootingProblem(std::vector<double> initial_state, std::vector<Phase> phases, Phase terminal);
  ShootingProblem(ShootingProblem&&) = default;  // views stay where the phases' vectors are
  ShootingProblem(const ShootingProblem&) = delete;

  const std::vector<Phase>& phases() const { return phases_; }
  const Phase& terminal() const { return terminal_; }
  const std::vector<double>& initial_state() const { return initial_state_; }
  /// Moves the initial state, for the next of several solves of one problem: never during one. `x`
  /// has nx numbers; throws std::invalid_argument where it has not.
  void set_initial_state(std::span<const double> x);
  /// Replaces the numbers of all nodes, N + 1 of them, for the next of several solves: never during
  /// one, and without allocation. The structure has to stay: which constraints are switched off,
  /// which weights are zero, and which knots take no time.
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
  /// The same of a trajectory, where phases last as long as its states say (FreeDuration).
  std::vector<double> times(const Trajectory& trajectory) const;
  bool has_free_durations() const;
  bool has_control_bounds() const;
  /// Whether a running knot takes no time: an impulse, or a phase that is instant.
  bool takes_no_time(int k) const { return times_[k] == times_[k + 1]; }
  /// The constraints of all nodes in order, but bounds on the control and those that are soft by a
  /// square, which are costs. Views into this problem.
  const std::vector<NodeConstraint>& constraints() const { return constraints_; }
  /// All that are soft, in order.
  const std::vector<NodeConstraint>& soft_constraints() const { return soft_constraints_; }
  /// The constraint rows of a node start here among those of the problem, used or not.
  int constraint_offset(int k) const { return constraint_offset_[k]; }
  int constraint_rows() const { return constraint_offset_.back(); }

  /// A trajectory of this problem's shape: every state the initial one, controls zero.
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

}  // namespace conddp
