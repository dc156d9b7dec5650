#pragma once

#include "ocp/evaluation/linearization.hpp"
#include "solvers/linalg/lane_matrix.hpp"
#include "solvers/stages/action_value.hpp"
#include "solvers/stages/value_function.hpp"

namespace conddp {

/// The products of a stage with dense dynamics whose z = (δx, δu) fits one lane. The compiler knows
/// how many states there are, and all matrices stay in registers. Sums have the order of the
/// products for any size: both give the same bits.
struct NarrowStage {
  /// Q_zz of `q`, which is shaped for the knot, ← Hessian + Fᵀ V_xx F.
  void (*pull)(const KnotLinearization& knot, const Eigen::MatrixXd& Vxx, ActionValue& q);

  /// V_xx ← Q_xx + Kᵀ Q_ux, of which the lower triangle is formed and mirrored, and
  /// V_x ← Q_x + Kᵀ w + Q_xu k. w and k have nu numbers. False where a number is not finite.
  bool (*form_value)(const ActionValue& q, const LaneBlock& Kt, const double* w, const double* k,
                     ValueFunction& value);
};

/// Null where a stage of this size is none.
const NarrowStage* narrow_stage(int ndx, int nu);

}  // namespace conddp
