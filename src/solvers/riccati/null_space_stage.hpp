#pragma once

#include <memory>
#include <vector>

#include "solvers/linalg/lane_matrix.hpp"
#include "solvers/linalg/row_elimination.hpp"
#include "solvers/riccati/linear_rollout.hpp"
#include "solvers/stages/stage_solver.hpp"

namespace conddp {

/// Stages with equality constraints, kept exactly in the linear model, those of later nodes too.
///
/// Beside the value function linear rows H δx + h = 0 travel backward: what the controls from a
/// node on cannot do for the constraints there. At a knot the rows of its constraints C z + c = 0
/// and those of the next node through the dynamics, H (T z + gap) + h = 0, are orthonormalised in
/// the control's columns (RowElimination). The rank r of them fix δu in their span, Q₁ᵀ δu = −(n +
/// N δx); in the null space Z of the others δu minimises the stage,
///   δu = −Q₁ (n + N δx) + Z b, b = −(Zᵀ Q_uu Z)⁻¹ Zᵀ (Q_u + Q_ux δx − Q_uu Q₁ (n + N δx)).
/// Rows left without control, orthonormalised in the state's columns, are the H δx + h = 0 of this
/// node; dependent ones are left out, and say nothing new unless they contradict the others.
class NullSpaceStage : public StageSolver {
 public:
  explicit NullSpaceStage(const ShootingProblem& problem);

  void begin_horizon(const Linearization& linearization, const Gaps& gaps) override;
  bool solve(const StageProblem& stage, Eigen::Ref<Eigen::VectorXd> k,
             const LaneBlock& Kt) override;
  void pass(int knot) override;
  bool minimizes_freely() const override { return false; }

  /// What the constraint multipliers of the last sweep's step add to those in the gradients, a
  /// number per constraint row of the problem: a pass forward along that step, as the multipliers
  /// of rows that travelled are decided where these were used.
  const Eigen::VectorXd& find_multipliers(const LinearRollout& step);
  /// How much the constraints contradict each other in the linear model: the largest value of a
  /// row, scaled to norm 1, that no step can change.
  double contradiction() const { return contradiction_; }

 private:
  struct Node {
    std::vector<int> rows;  ///< constraint rows of the problem
    std::vector<double> target;
    RowElimination system;  ///< columns (δu, δx, 1)
    int used = 0;           ///< rows that fix δu: r
    int passed = 0;         ///< rows behind them that travel on
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
