#pragma once

#include <span>
#include <vector>

#include "nlp/cone_row.hpp"
#include "nlp/nonlinear_program.hpp"
#include "nlp/pair_relaxation.hpp"
#include "nlp/state_chart.hpp"
#include "ocp/evaluation/evaluator.hpp"

namespace conddp {

/// A shooting problem as a sparse nonlinear program, by multiple shooting.
///
/// Variables, node by node: coordinates w_k of the state in the node's chart (k ≥ 1; x_0 is given)
/// and the control u_k. Rows, node by node: the constraints that hold there, then the gap in the
/// chart of the next node, (f(x_k, u_k) ⊖ c_{k+1}) − w_{k+1} = 0, which is linear in w_{k+1}.
/// Where q⁺ = q + dt v⁺ on a flat part, its row is (q_k + dt v_{k+1}) − q_{k+1} = 0 instead: the
/// row above less dt times that of v⁺, with three entries and no curvature. Bounds and norms are
/// the constraint's own rows, but ‖r‖ ≤ radius is ‖r‖²/(2 radius) ≤ radius/2, which has no kink. A
/// second-order cone is a ConeRow: that of its surface, or where it is soft that of its distance.
///
/// Complementary pairs become what PairRelaxation says, with bounds z ≥ 0 and s ≥ 0 on the controls
/// that they are.
///
/// Gap rows and Hessians have the entries that can be non-zero and no others, where the structure
/// of the problem tells them: flat configurations, costs and constraints of some columns.
///
/// A row of a constraint that is soft by its distance has a slack s ≥ 0 for each of its bounds, by
/// which it may be missed at the price of its limit. Slacks follow all other variables.
///
/// Constraints at node 0 that do not depend on the control are no rows: nothing can change them.
/// Nor are those at node 1 that depend on what a choice of the initial state leaves as it is given:
/// an interior point would look for an interior between a value and the bound that it is at.
class Transcription : public NonlinearProgram {
 public:
  struct Options {
    bool gauss_newton = false;     ///< Hessians without second derivatives of f, residuals and g
    double cone_smoothing = 1e-7;  ///< ε, in the unit of t
    PairRelaxation relaxation = PairRelaxation::elementwise;
    double epsilon = 1;  ///< of the relaxation, at first
  };
  Transcription(const ShootingProblem& problem, Evaluator& evaluator, const Options& options);

  void set_point(const double* y) override;
  double objective() override;
  void gradient(double* out) override;
  void constraints(double* out) override;
  void jacobian(double* out) override;
  void hessian(double weight, const double* multipliers, double* out) override;

  /// Whether the next Hessians are Gauss-Newton's, with zeros where only exact ones have entries.
  /// They are in any case where the options say so.
  void use_gauss_newton(bool use) { gauss_newton_ = use || options_.gauss_newton; }

  /// Makes the states of a trajectory the centres of the charts. Points mean other states then.
  void set_center(const Trajectory& trajectory);
  /// The point that stands for a trajectory; its x_0 is ignored.
  Eigen::VectorXd point_of(const Trajectory& trajectory) const;
  /// Sets ε of the relaxed pairs. Values at the present point change.
  void relax(double epsilon);
  /// Fixes the smaller one of each pair at a point to zero, and leaves the relaxed rows out. The
  /// next `relax` takes that back.
  void fix_pairs(const double* y);
  /// Largest |min(z, s)| of all pairs at a point.
  double pair_distance(const double* y) const;
  bool has_pairs() const { return !pairs_.empty(); }
  /// Whether a row of a constraint depends on a state and a control together, as contact forces do.
  bool has_mixed_rows() const;
  /// At the present point: for each variable 1, or this weight where it is one of a state that sums
  /// up a cost: the costs read its end, its own equation alone reads it, and that one is curved.
  /// The co-state of such a state is the same along the whole motion.
  Eigen::VectorXd weights_of_cost_states(double weight);

  /// The trajectory at the present point.
  const Trajectory& trajectory() const { return trajectory_; }
  /// Copies what belongs to controls out of a vector with a number for each variable.
  void read_controls(const double* variables, Trajectory& trajectory) const;
  /// Largest rotation of a state at the present point from its chart's centre, rad.
  double chart_angle() const;

  /// Multipliers of the rows at the present point in the conventions of the Lagrangian
  /// Σ λ_{k+1}ᵀ (f ⊖ x_{k+1}) + Σ νᵀ g: λ as ndx x (N + 1), its first column zero, and ν of all
  /// constraint rows of the problem.
  /// Of a pair the smaller one has the multiplier that makes the Lagrangian stationary, the other
  /// none unless it stands at zero as well.
  void read_multipliers(const double* rows, Eigen::MatrixXd& costates, Eigen::VectorXd& nu);
  /// The other way round, at the present point with its states as centres: the multipliers of rows,
  /// and of variables from ∇_u of the Lagrangian without them.
  void write_multipliers(const Eigen::MatrixXd& costates, const Eigen::VectorXd& nu,
                         const std::vector<Eigen::VectorXd>& control_gradient,
                         Eigen::VectorXd& rows, Eigen::VectorXd& lower,
                         Eigen::VectorXd& upper) const;
  /// The multipliers that mean the same with the present states as centres.
  void recenter_multipliers(double* rows);

  /// Whether a node has constraints that are no rows.
  bool has_given_constraints(int node) const { return node < given_nodes_; }
  /// Costs, gaps (as f ⊖ x⁺, not in charts) and constraint values at the present point.
  const Evaluation& evaluation();

 private:
  /// A row that comes from constraint rows of a node: one of them, all of a cone, or pairs.
  struct Row {
    const NodeConstraint* constraint;
    int first;                        ///< constraint row of the problem
    int count;                        ///< 1, or those of the cone or the pairs
    std::vector<int> columns;         ///< of z on which it depends, without x_0
    int index;                        ///< among the program's rows
    double radius = 0;                ///< of a row ‖r‖²/(2 radius) instead of ‖r‖
    int first_slack = 0, slacks = 0;  ///< among slacks_
  };
  /// What a soft row may miss a bound by, added to the row with a sign.
  struct Slack {
    int variable;
    double sign, price;
  };
  /// Two variables that are complementary, at a node, and their first constraint row.
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
  /// Flat rows of q⁺ = q + dt v⁺ of a knot, unless its system's steps are linear anyway.
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
  /// The value of a row of the program at its constraint rows g, and its derivative by them.
  double row_value(const Row& row, const double* g, double* slope) const;
  bool is_penalty() const { return options_.relaxation == PairRelaxation::penalty; }
  double penalty_value(const double* y) const;
  void add_penalty_gradient(double* out) const;
  /// Of the other one of its pair in the objective.
  double penalty_slope(int variable) const { return is_penalty() ? y_[variable] / epsilon_ : 0; }
  void set_slacks(const Trajectory& trajectory, Eigen::VectorXd& y) const;
  /// Bounds of the relaxed rows.
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
  /// Multipliers of gap rows of a knot from those of f ⊖ c − w.
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
  bool exact_in_place_ = false;  ///< the linearisation's Hessians are exact
  bool curved_;
  std::vector<StateChart> charts_;      ///< of nodes 0 … N; that of node 0 is not used
  std::vector<StateChart> next_;        ///< the same charts at f(x_{k−1}, u_{k−1})
  std::vector<int> base_;               ///< variable of column 0 of z, node by node
  std::vector<std::vector<Row>> rows_;  ///< by node
  std::vector<int> gap_row_;            ///< first one of each knot
  std::vector<bool> given_;             ///< of node 1: columns that no control moves; or empty
  int given_nodes_ = 1;                 ///< the first ones, with constraints that are no rows
  /// Of each knot, (row, column) of ∂f/∂z in the order of the gap rows' entries.
  std::vector<std::vector<std::pair<int, int>>> gap_entries_;
  std::vector<std::vector<int>> kinematic_rows_;  ///< of each knot, among its gap rows
  std::vector<Pair> pairs_;
  double epsilon_;
  std::vector<std::vector<std::pair<int, int>>> hessian_entries_;  ///< of z, node by node

  Eigen::VectorXd y_;
  Trajectory trajectory_;
  bool evaluated_ = false, differentiated_ = false;
  Evaluation evaluation_;
  Linearization linearization_;
  Eigen::MatrixXd coordinates_;    ///< w of every node, ndx x (N + 1)
  Eigen::MatrixXd gap_rows_;       ///< ndx x N: gaps in the charts
  std::vector<bool> fixed_;        ///< of the node whose rows are added: by column of z
  Eigen::MatrixXd mu_, costates_;  ///< multipliers of gap rows, and as co-states
  std::vector<Slack> slacks_;
  /// A variable of no row that costs half its square, or −1: Ipopt minimizes nothing where
  /// equations are as many as variables, and of pairs with fixed sides they may be.
  int spare_ = -1;
  Augmentation lagrangian_;                    ///< ν
  Eigen::VectorXd image_, image_coordinates_;  ///< of f(x_k, u_k)
  Eigen::VectorXd z_, z_scratch_, slope_;
  Eigen::MatrixXd matrix_, jacobian_rows_, block_;
};

}  // namespace conddp
