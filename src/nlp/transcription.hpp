#pragma once

#include <span>
#include <vector>

#include "nlp/nonlinear_program.hpp"
#include "nlp/relaxed_rows.hpp"
#include "nlp/state_chart.hpp"
#include "ocp/evaluation/evaluator.hpp"

namespace conddp {

/// A shooting problem as a sparse nonlinear program, by multiple shooting.
///
/// Variables, node by node: coordinates w_k of the state in the node's chart (k ≥ 1; x_0 is given)
/// and the control u_k.
///
/// Rows, node by node: the node's constraints, then the gap in the chart of the next node,
///   (f(x_k, u_k) ⊖ c_{k+1}) − w_{k+1} = 0,
/// which is linear in w_{k+1}. On a flat part with q⁺ = q + dt v⁺, the row is
///   (q_k + dt v_{k+1}) − q_{k+1} = 0
/// instead. This is the row above minus dt times the row of v⁺, with three entries and zero
/// curvature.
///
/// Bounds and norms are the constraint's own rows. The exception is ‖r‖ ≤ radius, which becomes
///   ‖r‖²/(2 radius) ≤ radius/2
/// without a kink. A second-order cone is a ConeRow: the surface form, or the distance form if it
/// is soft. Complementary pairs follow PairRelaxation; the bounds on their controls are z ≥ 0 and
/// s ≥ 0.
///
/// Gap rows and Hessians have only the entries that can be nonzero, as far as the problem's
/// structure shows: flat configurations, costs and constraints of some columns.
///
/// A row of a constraint that is soft by its distance has a slack s ≥ 0 for each of its bounds. The
/// slack allows a violation at the price of the constraint's limit. Slacks follow all other
/// variables.
///
/// Constraints at node 0 that do not depend on the control are omitted: nothing can change them.
/// Constraints at node 1 are omitted if they depend only on coordinates that a free initial state
/// leaves as given. Otherwise an interior-point method would look for an interior between a value
/// and the bound that it is at.
class Transcription : public NonlinearProgram {
 public:
  struct Options {
    bool gauss_newton = false;     ///< Hessians omit second derivatives of f, residuals and g
    double cone_smoothing = 1e-7;  ///< ε, in the unit of t
    PairRelaxation relaxation = PairRelaxation::elementwise;
    double epsilon = 1;  ///< initial ε of the relaxation
  };
  Transcription(const ShootingProblem& problem, Evaluator& evaluator, const Options& options);

  void set_point(const double* y) override;
  double objective() override;
  void gradient(double* out) override;
  void constraints(double* out) override;
  void jacobian(double* out) override;
  void hessian(double weight, const double* multipliers, double* out) override;

  /// With `use`, the next Hessians are Gauss-Newton, with zeros where only exact ones have entries;
  /// otherwise they are exact. With Options::gauss_newton, all Hessians are Gauss-Newton.
  void use_gauss_newton(bool use) { gauss_newton_ = use || options_.gauss_newton; }

  /// Makes the states of a trajectory the centers of the charts. Points then represent other
  /// states.
  void set_center(const Trajectory& trajectory);
  /// Point that represents a trajectory; its x_0 is ignored.
  Eigen::VectorXd point_of(const Trajectory& trajectory) const;
  /// Sets ε of the relaxed pairs. Values at the current point change.
  void relax(double epsilon);
  /// Fixes the smaller variable of each pair at a point to zero and disables the relaxed rows. The
  /// next `relax` undoes this.
  void fix_pairs(const double* y);
  /// Largest |min(z, s)| over all pairs at a point.
  double pair_distance(const double* y) const;
  bool has_pairs() const { return !pairs_.empty(); }
  /// True if a constraint row depends on states and controls together, as contact forces do.
  bool has_mixed_rows() const;
  /// Weights of the variables at the current point: `weight` for a state that sums up a cost, 1 for
  /// all others. The costs depend on the final value of such a state; only its own equation
  /// contains it, and that equation is nonlinear. Its co-state is constant along the whole motion.
  Eigen::VectorXd weights_of_cost_states(double weight);

  /// Trajectory at the current point.
  const Trajectory& trajectory() const { return trajectory_; }
  /// Copies the entries of controls from a vector with a number for each variable.
  void read_controls(const double* variables, Trajectory& trajectory) const;
  /// Largest rotation of a state at the current point from its chart's center, rad.
  double chart_angle() const;

  /// Converts multipliers of the rows at the current point to the conventions of the Lagrangian Σ
  /// λ_{k+1}ᵀ (f ⊖ x_{k+1}) + Σ νᵀ g. The co-states λ are ndx x (N + 1) with a zero first column; ν
  /// covers all constraint rows of the problem. The smaller variable of a pair has the multiplier
  /// that makes the Lagrangian stationary. The multiplier of the larger one is zero unless that
  /// variable is at zero as well.
  void read_multipliers(const double* rows, Eigen::MatrixXd& costates, Eigen::VectorXd& nu);
  /// Inverse conversion, at the current point with its states as centers: multipliers of rows, and
  /// multipliers of variables from ∇_u of the Lagrangian without them.
  void write_multipliers(const Eigen::MatrixXd& costates, const Eigen::VectorXd& nu,
                         const std::vector<Eigen::VectorXd>& control_gradient,
                         Eigen::VectorXd& rows, Eigen::VectorXd& lower,
                         Eigen::VectorXd& upper) const;
  /// Converts the multipliers to equivalent ones with the current states as centers.
  void recenter_multipliers(double* rows);

  /// True if a node has constraints that are omitted from the rows.
  bool has_given_constraints(int node) const { return node < given_nodes_; }
  /// Costs, gaps (as f ⊖ x⁺, not in charts) and constraint values at the current point.
  const Evaluation& evaluation();

 private:
  /// A row built from constraint rows of a node: a single one, all of a cone, or pairs.
  struct Row {
    const NodeConstraint* constraint;
    int first;                 ///< first constraint row in the problem
    int count;                 ///< 1, or the number of rows of the cone or the pairs
    std::vector<int> columns;  ///< columns of z that it depends on, without x_0
    int index;                 ///< index among the program's rows
    double radius = 0;         ///< if positive, the row is ‖r‖²/(2 radius) instead of ‖r‖
    int first_slack = 0, slacks = 0;  ///< range in slacks_
  };
  /// Permitted violation of a soft row's bound, added to the row with a sign.
  struct Slack {
    int variable;
    double sign, price;
  };
  /// Two complementary variables at a node, and their first constraint row.
  struct Pair {
    int node, z, s, row;
  };

  void add_variables();
  void find_fixed_columns(std::span<const NodeConstraint> of_node, int node);
  void add_rows();
  void add_constraint(const NodeConstraint& constraint);
  void add_bounds(const NodeConstraint& constraint);
  void find_given_columns();
  bool is_given(int node, const std::vector<bool>& columns) const;
  std::vector<int> columns_of(int node, int first, int count) const;
  void add_row(const NodeConstraint& constraint, int first, int count, double lower, double upper,
               double radius = 0);
  void add_norm(const NodeConstraint& constraint);
  void add_slacks(Row& row, int index, double lower, double upper);
  void add_pairs(const NodeConstraint& constraint);
  void add_gap_rows(int node);
  /// Flat rows q⁺ = q + dt v⁺ of a knot; empty if the steps of its system are linear anyway.
  std::vector<int> find_kinematic_rows(int node) const;
  void index_hessian();
  class BlockPattern;
  bool has_full_hessian(int node) const;
  BlockPattern hessian_pattern(int node) const;
  void add_pair_entries(int node, BlockPattern& used) const;
  void add_step_curvature(const KnotModel& model, BlockPattern& used) const;
  bool is_cone(const Row& row) const { return row.constraint->term->is_cone(); }
  ConeRow cone_row(const Row& row) const;
  bool has_pairs(const Row& row) const { return row.constraint->term->has_pairs(); }
  /// Value of a program row at its constraint rows g, and its derivative with respect to them.
  double row_value(const Row& row, const double* g, double* slope) const;
  bool is_penalty() const { return options_.relaxation == PairRelaxation::penalty; }
  double penalty_value(const double* y) const;
  void add_penalty_gradient(double* out) const;
  /// Slope of the penalty in the other variable of the pair.
  double penalty_slope(int variable) const { return is_penalty() ? y_[variable] / epsilon_ : 0; }
  void set_slacks(const Trajectory& trajectory, Eigen::VectorXd& y) const;
  /// Sets the bounds of the relaxed rows.
  void bound_pair_rows(double lower, double upper);
  int first_column(int node) const { return node == 0 ? problem_.ndx() : 0; }
  void evaluate();
  void differentiate();
  void read_charts(const Eigen::MatrixXd& gap);
  void add_pair_curvature(const Row& row, double weight, Eigen::Ref<Eigen::MatrixXd> hessian);
  double* write_row_entries(int node, double* out);
  double* write_gap_entries(int node, double* out);
  void spread(const double* rows);
  const double* spread_constraints(int node, const double* rows);
  Eigen::VectorXd slope_without_pairs(const double* rows);
  void read_pair(const Pair& pair, const Eigen::VectorXd& slope, Eigen::VectorXd& nu) const;
  void write_bound_multipliers(int node, const Eigen::VectorXd& gradient, Eigen::VectorXd& lower,
                               Eigen::VectorXd& upper) const;
  /// Converts multipliers of f ⊖ c − w to multipliers of a knot's gap rows.
  void push_gap_multipliers(int node, double* gap_rows) const;
  void fill_dynamics(const KnotLinearization& knot);
  void evaluate_hessians(double weight);
  void add_row_curvature(int node, const double* multipliers, Eigen::MatrixXd& hessian);
  void add_row_curvature(const Row& row, double multiplier, Eigen::MatrixXd& hessian);
  void pull_to_chart(int node, double weight, Eigen::MatrixXd& hessian);
  void add_penalty_curvature(int node, double weight, Eigen::MatrixXd& hessian) const;
  void add_gap_curvature(int k, Eigen::Ref<Eigen::MatrixXd> hessian);

  const ShootingProblem& problem_;
  Evaluator& evaluator_;
  Options options_;
  bool gauss_newton_;
  bool exact_in_place_ = false;  ///< the linearization's Hessians are exact
  bool curved_;
  std::vector<StateChart> charts_;      ///< of nodes 0 … N; the first is unused
  std::vector<StateChart> next_;        ///< the same charts at f(x_{k−1}, u_{k−1})
  std::vector<int> base_;               ///< variable of column 0 of z, by node
  std::vector<std::vector<Row>> rows_;  ///< by node
  std::vector<int> gap_row_;            ///< first gap row of each knot
  std::vector<bool> given_;             ///< of node 1: columns that no control moves; may be empty
  int given_nodes_ = 1;                 ///< constraints may be omitted only before this node
  /// By knot, (row, column) of ∂f/∂z in the order of the gap rows' entries.
  std::vector<std::vector<std::pair<int, int>>> gap_entries_;
  std::vector<std::vector<int>> kinematic_rows_;  ///< by knot, among its gap rows
  std::vector<Pair> pairs_;
  double epsilon_;
  std::vector<std::vector<std::pair<int, int>>> hessian_entries_;  ///< of z, by node

  Eigen::VectorXd y_;
  Trajectory trajectory_;
  bool evaluated_ = false, differentiated_ = false;
  Evaluation evaluation_;
  Linearization linearization_;
  Eigen::MatrixXd coordinates_;    ///< w of every node, ndx x (N + 1)
  Eigen::MatrixXd gap_rows_;       ///< ndx x N: gaps in the charts
  std::vector<bool> fixed_;        ///< columns of z that are fixed at the node whose rows are being
                                   ///< added
  Eigen::MatrixXd mu_, costates_;  ///< multipliers of gap rows; the same as co-states
  std::vector<Slack> slacks_;
  /// A variable without rows that costs half its square, or −1. Ipopt does not minimize if
  /// equations are as many as variables, which can happen for pairs with fixed sides.
  int spare_ = -1;
  Augmentation lagrangian_;                    ///< ν
  Eigen::VectorXd image_, image_coordinates_;  ///< f(x_k, u_k) and its coordinates
  Eigen::VectorXd z_, z_scratch_, slope_;
  Eigen::MatrixXd matrix_, jacobian_rows_, block_;
};

}  // namespace conddp
