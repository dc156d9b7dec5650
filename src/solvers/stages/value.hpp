#pragma once

#include <vector>

#include <Eigen/Core>

#include "ocp/evaluation/linearization.hpp"
#include "solvers/linalg/lane_matrix.hpp"
#include "solvers/stages/value_function.hpp"

namespace conddp {

class GapTransport;

/// Carries a value function backward through a knot's dynamics δx⁺ = T δz:
///   Q_z = gradient + Tᵀ V_x,  Q_zz = Hessian + Tᵀ V_xx T.
/// Semi-implicit Euler dynamics have the structure δv⁺ = F δz and δq⁺ = A δq + dt H δv⁺. For them,
/// V_xx is first transformed to (δq, δv⁺), so that only products with F's nv rows remain.
/// Workspaces are sized at construction.
class ValuePropagation {
 public:
  ValuePropagation(int ndx, int max_nu);

  /// Fills `q` and shapes it for the knot. `next` is the value at x_{k+1}; `gap`, if given, lies
  /// between the knot's dynamics and that node.
  void propagate(const KnotLinearization& knot, const ValueFunction& next, ActionValue& q,
                 const GapTransport* gap = nullptr);

 private:
  /// A knot's blocks of δq⁺ = A δq + dt H δv⁺.
  using StateBlocks = std::vector<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>;

  /// The next value across the gap, as a knot's dynamics see it.
  struct NextValue {
    const Eigen::VectorXd& Vx;
    const Eigen::MatrixXd& Vxx;
    bool turn_blocks;  ///< G of the gap still has to multiply the blocks of semi-implicit dynamics
  };
  NextValue over_gap(const GapTransport* gap, const KnotLinearization& knot,
                     const ValueFunction& next);
  void pull_semi_implicit(const KnotLinearization& knot, const NextValue& next,
                          const GapTransport* gap);
  void turn_blocks(const GapTransport& gap, const KnotLinearization& knot);
  void transform(const KnotLinearization& knot, const StateBlocks& A, const StateBlocks& H,
                 const Eigen::MatrixXd& Vxx);

  Eigen::VectorXd scratch_, pulled_;
  ValueFunction moved_;  // the next value, moved across a gap
  StateBlocks GA_, GH_;
  LaneMatrix Ft_, FtP_;         // nz x rows of F
  LaneMatrix P11_, P12_, P22_;  // nv x nv, with zero padding
};

}  // namespace conddp
