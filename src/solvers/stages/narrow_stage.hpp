#pragma once

#include "ocp/evaluation/linearization.hpp"
#include "solvers/linalg/lane_matrix.hpp"
#include "solvers/stages/value_function.hpp"

namespace conddp {

/// Products of a stage with dense dynamics whose z = (δx, δu) fits one lane. The number of states
/// is a compile-time constant, and all matrices stay in registers. Sums have the same order as in
/// the products for any size, so that both give the same bits.
struct NarrowStage {
  /// Q_zz of `q` ← Hessian + Fᵀ V_xx F; `q` is already shaped for the knot.
  void (*pull)(const KnotLinearization& knot, const Eigen::MatrixXd& Vxx, ActionValue& q);

  /// V_xx ← Q_xx + Kᵀ Q_ux, formed in the lower triangle and mirrored, and V_x ← Q_x + Kᵀ w + Q_xu
  /// k. w and k have nu entries. False if a number is not finite.
  bool (*form_value)(const ActionValue& q, const LaneBlock& Kt, const double* w, const double* k,
                     ValueFunction& value);
};

/// Null if a stage of this size does not fit.
const NarrowStage* narrow_stage(int ndx, int nu);

}  // namespace conddp
