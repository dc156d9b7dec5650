#pragma once

#include <memory>
#include <vector>

#include "solvers/linalg/lane_matrix.hpp"
#include "solvers/linalg/row_elimination.hpp"
#include "solvers/riccati/linear_rollout.hpp"
#include "solvers/stages/stage_solver.hpp"

namespace conddp {

/// Stages that enforce equality constraints exactly in the linear model, including those of later
/// nodes.
///
/// Linear rows H δx + h = 0 travel backward alongside the value function. They are the part of the
/// later constraints that the controls from a node on cannot satisfy. A knot collects the rows of
/// its constraints, C z + c = 0, and those of the next node through the dynamics,
/// H (T z + gap) + h = 0. They are orthonormalized in the control's columns (RowElimination). The
/// resulting r independent rows fix δu in their span, Q₁ᵀ δu = −(n + N δx). In their null space Z,
/// δu minimizes the stage:
///   δu = −Q₁ (n + N δx) + Z b, b = −(Zᵀ Q_uu Z)⁻¹ Zᵀ (Q_u + Q_ux δx − Q_uu Q₁ (n + N δx)).
/// The rows that remain without control are orthonormalized in the state's columns and become the
/// H δx + h = 0 of this node. Dependent rows are dropped; they matter only if they contradict the
/// others.
class NullSpaceStage : public StageSolver {
 public:
  explicit NullSpaceStage(const ShootingProblem& problem);

  void begin_horizon(const Linearization& linearization, const Gaps& gaps) override;
  bool solve(const StageProblem& stage, Eigen::Ref<Eigen::VectorXd> k,
             const LaneBlock& Kt) override;
  void pass(int knot) override;
  bool minimizes_freely() const override { return false; }

  /// Change of the constraint multipliers by the last sweep's step, relative to those in the
  /// gradients, with one entry per constraint row of the problem. Computed by a forward pass along
  /// that step: the knot whose controls satisfy a row also determines its multiplier.
  const Eigen::VectorXd& find_multipliers(const LinearRollout& step);
  /// Contradiction of the constraints in the linear model: the largest value of a row, scaled to
  /// norm 1, that no step can change.
  double contradiction() const { return contradiction_; }

 private:
  struct Node {
    std::vector<int> rows;  ///< constraint rows of the problem
    std::vector<double> target;
    RowElimination system;  ///< columns (δu, δx, 1)
    int used = 0;           ///< number of rows that fix δu: r
    int passed = 0;         ///< number of following rows, which travel on
    Eigen::MatrixXd Quu, Qxu;
    Eigen::VectorXd Qu;
  };
  void assign_rows();
  void collect(int node);
  void eliminate(int node, int nu);
  void complete_basis(const Node& node, int nu);

  const ShootingProblem& problem_;
  const Linearization* linearization_ = nullptr;
  const Gaps* gaps_ = nullptr;
  std::vector<Node> nodes_;
  double contradiction_ = 0;
  Eigen::VectorXd multipliers_;
  Eigen::MatrixXd basis_;                        ///< nu x nu: Q₁, Z
  Eigen::MatrixXd QZ_, affine_, product_, rhs_;  ///< scratch
  LaneMatrix reduced_{0, 0};                     ///< scratch
  Eigen::VectorXd row_, pulled_, costate_, eta_, y_, above_, gradient_;
};

}  // namespace conddp
