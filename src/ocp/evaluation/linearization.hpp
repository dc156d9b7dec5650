#pragma once

#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// Entries of a knot's Hessian that may be nonzero.
enum class HessianFill {
  lasting,  ///< the first entries of the model's pattern, which its costs always fill
  pattern,  ///< all entries of the pattern
  all,
};

/// The symmetric nz x nz Hessian of a knot. It tracks which entries may be nonzero, so all writes
/// go through `change`.
class KnotHessian {
 public:
  KnotHessian() = default;
  /// Zero matrix; `lasting` lists the entries (row, column), row >= column, that costs always fill.
  KnotHessian(int nz, std::span<const std::pair<int, int>> lasting);

  const Eigen::MatrixXd& operator()() const { return matrix_; }
  /// The matrix for writing, only into the entries of `fill`. All others are zero, or keep their
  /// values if `fill` is `all`.
  Eigen::MatrixXd& change(HessianFill fill = HessianFill::all) {
    if (fill_ > fill) matrix_.setZero();
    fill_ = fill;
    return matrix_;
  }

  HessianFill fill() const { return fill_; }
  /// Start of kLaneWidth entries of a column in the lower triangle, at least one of them lasting.
  struct LanePlace {
    int row;  ///< a multiple of kLaneWidth
    int column;
  };
  const std::vector<LanePlace>& lasting_lanes() const { return lasting_lanes_; }

 private:
  Eigen::MatrixXd matrix_;
  HessianFill fill_ = HessianFill::all;
  std::vector<LanePlace> lasting_lanes_;
};

/// The quadratic model of one knot around a trajectory, in z = (δx, δu).
///
/// Dynamics: dense, δx⁺ = F δz; or semi-implicit, δv⁺ = F δz with δq⁺ = A δq + dt H δv⁺. A and H
/// are the identity except for one block per curved segment.
struct KnotLinearization {
  Eigen::VectorXd gradient;  ///< nz: of cost and augmentation
  KnotHessian hessian;       ///< nz x nz: of cost and augmentation, or of the Lagrangian
  Eigen::MatrixXd F;         ///< jacobian_rows x nz
  Eigen::MatrixXd C;         ///< ∂g/∂z of the constraint rows x nz
  bool semi_implicit = false;
  double dt = 0;
  std::vector<StateManifold::Segment> curved;                      ///< of the configuration
  std::vector<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> A, H;  ///< top left n x n block used

  int ndx = 0;
  int nu() const { return static_cast<int>(gradient.size()) - ndx; }

  /// out = ∂x⁺/∂z · z (ndx).
  void apply(const Eigen::Ref<const Eigen::VectorXd>& z, Eigen::Ref<Eigen::VectorXd> out) const;
  /// out = (∂x⁺/∂z)ᵀ λ (nz); scratch has ndx numbers.
  void apply_transpose(const Eigen::Ref<const Eigen::VectorXd>& lambda,
                       Eigen::Ref<Eigen::VectorXd> out, Eigen::Ref<Eigen::VectorXd> scratch) const;
  /// ∂x⁺/∂z as a dense ndx x nz matrix, for tests and certificates.
  Eigen::MatrixXd dense_jacobian() const;
};

/// The quadratic model of a whole problem around a trajectory.
struct Linearization {
  explicit Linearization(const ShootingProblem& problem);

  std::vector<KnotLinearization> knots;  ///< N + 1; the last one without controls and F
  Eigen::MatrixXd gap;                   ///< ndx x N: f(x_k, u_k) ⊖ x_{k+1}
  Eigen::VectorXd cost;                  ///< N + 1
  Eigen::VectorXd augmentation;          ///< N + 1: contribution of the constraints to the cost
  Eigen::VectorXd constraint;            ///< g, all constraint rows of the problem

  /// Exchanges the memory of knots with that of another problem's knots, in order, if their models
  /// are the same. Its contents are undefined until the next differentiation.
  void exchange(const ShootingProblem& own, Linearization& other, const ShootingProblem& others);

  double total_cost() const { return cost.sum(); }
  double max_gap() const { return gap.size() == 0 ? 0.0 : gap.cwiseAbs().maxCoeff(); }
};

}  // namespace conddp
