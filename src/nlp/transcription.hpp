#pragma once

#include <vector>

#include "nlp/nonlinear_program.hpp"
#include "nlp/state_chart.hpp"
#include "ocp/acts.hpp"

namespace conddp {

/// A shooting problem as a sparse nonlinear program, by multiple shooting.
///
/// Variables, node by node: coordinates w_k of the state in the node's chart (k ≥ 1; x_0 is given)
/// and the control u_k. Rows, node by node: the constraints that hold there, then the gap in the
/// chart of the next node, (f(x_k, u_k) ⊖ c_{k+1}) − w_{k+1} = 0, which is linear in w_{k+1}.
/// Bounds and norms are the constraint's own rows. A second-order cone ‖v‖ ≤ t is the row
///   h = t − √(‖v‖² + ε²) + ε ≥ 0,
/// which is smooth, concave, never without a gradient, and weaker by ε at most.
///
/// Constraints at node 0 that do not depend on the control are no rows: nothing can change them.
class Transcription : public NonlinearProgram {
 public:
  struct Options {
    bool gauss_newton = false;     ///< Hessians without second derivatives of f, residuals and g
    double cone_smoothing = 1e-7;  ///< ε, in the unit of t
  };
  Transcription(const ShootingProblem& problem, Acts& acts, const Options& options);

  void set_point(const double* y) override;
  double objective() override;
  void gradient(double* out) override;
  void constraints(double* out) override;
  void jacobian(double* out) override;
  void hessian(double weight, const double* multipliers, double* out) override;

  /// Makes the states of a trajectory the centres of the charts. Points mean other states then.
  void set_center(const Trajectory& trajectory);
  /// The point that stands for a trajectory; its x_0 is ignored.
  Eigen::VectorXd point_of(const Trajectory& trajectory) const;
  /// The trajectory at the present point.
  const Trajectory& trajectory() const { return trajectory_; }
  /// Copies what belongs to controls out of a vector with a number for each variable.
  void read_controls(const double* variables, Trajectory& trajectory) const;
  /// Largest rotation of a state at the present point from its chart's centre, rad.
  double chart_angle() const;

  /// Multipliers of the rows at the present point in the conventions of the Lagrangian
  /// Σ λ_{k+1}ᵀ (f ⊖ x_{k+1}) + Σ νᵀ g: λ as ndx x (N + 1), its first column zero, and ν of all
  /// constraint rows of the problem.
  void read_multipliers(const double* rows, Eigen::MatrixXd& costates, Eigen::VectorXd& nu);
  /// The multipliers that mean the same with the present states as centres.
  void recenter_multipliers(double* rows);

  /// Costs, gaps (as f ⊖ x⁺, not in charts) and constraint values at the present point.
  const Evaluation& evaluation();

 private:
  /// A row that comes from constraint rows of a node: one of them, or all of a cone.
  struct Row {
    const NodeConstraint* constraint;
    int first;                 ///< constraint row of the problem
    int count;                 ///< 1, or those of the cone
    std::vector<int> columns;  ///< of z on which it depends, without x_0
  };

  void add_variables();
  void add_rows();
  void add_row(const NodeConstraint& constraint, int first, int count, double lower, double upper);
  void index_hessian();
  bool is_cone(const Row& row) const { return !row.constraint->term->has_bounds(); }
  int first_column(int node) const { return node == 0 ? problem_.ndx() : 0; }
  void evaluate();
  void differentiate();
  void read_charts(const Eigen::MatrixXd& gap);
  double cone_value(const double* g, int n, double* slope) const;
  void add_cone_curvature(const Row& row, double weight, Eigen::Ref<Eigen::MatrixXd> hessian);
  void spread(const double* rows);
  void fill_dynamics(const KnotLinearization& knot);
  void add_gap_curvature(int k, Eigen::Ref<Eigen::MatrixXd> hessian);

  const ShootingProblem& problem_;
  Acts& acts_;
  Options options_;
  bool curved_;
  std::vector<StateChart> charts_;      ///< of nodes 0 … N; that of node 0 is not used
  std::vector<StateChart> next_;        ///< the same charts at f(x_{k−1}, u_{k−1})
  std::vector<int> base_;               ///< variable of column 0 of z, node by node
  std::vector<std::vector<Row>> rows_;  ///< by node
  std::vector<int> gap_row_;            ///< first one of each knot
  std::vector<std::vector<std::pair<int, int>>> hessian_entries_;  ///< of z, node by node

  Eigen::VectorXd y_;
  Trajectory trajectory_;
  bool evaluated_ = false, differentiated_ = false;
  Evaluation evaluation_;
  Linearization linearization_;
  Eigen::MatrixXd coordinates_;                ///< w of every node, ndx x (N + 1)
  Eigen::MatrixXd gap_rows_;                   ///< ndx x N: gaps in the charts
  Eigen::MatrixXd mu_, costates_;              ///< multipliers of gap rows, and as co-states
  Augmentation lagrangian_;                    ///< ν
  Eigen::VectorXd image_, image_coordinates_;  ///< of f(x_k, u_k)
  Eigen::VectorXd z_, z_scratch_, slope_;
  Eigen::MatrixXd matrix_, jacobian_rows_, block_;
};

}  // namespace conddp
