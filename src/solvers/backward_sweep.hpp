#pragma once

#include <optional>
#include <vector>

#include "ocp/acts.hpp"
#include "solvers/control_bounds.hpp"
#include "solvers/gap_transport.hpp"
#include "solvers/stage_policy.hpp"
#include "solvers/value.hpp"

namespace conddp {

/// What a sweep adds to its stage problems.
struct SweepRegularization {
  RegularizationKind kind = RegularizationKind::state;
  double weight = 0;
};

/// The Riccati sweep of every DDP solver: from the last node to the first it prepares the next
/// value (gap), lets a policy solve the stage with regularised second derivatives, and forms the
/// value of the resulting policy with the true ones, which also holds where controls are clamped:
///   V_x  = Q_x + Kᵀ Q_uu k + Kᵀ Q_u + Q_xu k,
///   V_xx = Q_xx + Kᵀ Q_uu K + Kᵀ Q_ux + Q_xu K.
/// Without regularisation the rows of Q_uu K + Q_ux that K does not leave out are zero: then
///   V_xx = Q_xx + Kᵀ Q_ux.
class BackwardSweep {
 public:
  BackwardSweep(const ShootingProblem& problem, const ControlBounds& bounds);

  /// Fills `feedback`, for the full step that closes the gaps. Returns the knot
  /// whose stage has no minimum or is not finite, or −1 where all went well. `hold` is passed on
  /// to the policy. With `from` the sweep begins at that knot: what stands behind it is as the
  /// sweep before saw it, and so are its values and its part of `feedback`.
  int run(const Linearization& linearization, const Trajectory& trajectory, const Gaps& gaps,
          SweepRegularization regularization, StagePolicy& policy, Feedback& feedback,
          bool hold = false, std::optional<int> from = {});

  /// Value at node k after a sweep, with respect to δx_k.
  const ValueFunction& value(int k) const { return values_[k]; }
  /// Q_uu of a knot, without regularisation.
  const Eigen::MatrixXd& Quu(int k) const { return Quu_[k]; }
  /// Exchanges all of these with another set of the same shape.
  void swap_values(std::vector<ValueFunction>& other, std::vector<Eigen::MatrixXd>& other_Quu) {
    values_.swap(other);
    Quu_.swap(other_Quu);
  }

 private:
  bool solve_stage(int k, const Trajectory& trajectory, const KnotLinearization& knot,
                   SweepRegularization regularization, StagePolicy& policy, Feedback& feedback);
  /// `true_gains`: K comes from second derivatives without regularisation. False where the value is
  /// not finite.
  bool form_value(ValueFunction& value, const Eigen::VectorXd& k, bool true_gains);

  const ControlBounds& bounds_;
  std::vector<ValueFunction> values_;  ///< N + 1
  std::vector<Eigen::MatrixXd> Quu_;
  ValueFunction next_;
  ValuePropagation propagation_;
  ActionValue q_;
  LaneMatrix columns_;  ///< nz x nu: control columns of Q_zz, regularised
  LaneMatrix Kt_;       ///< ndx x nu, and one row more
  LaneMatrix M_;        ///< ndx x nu
  Eigen::VectorXd w_;   ///< nu
};

}  // namespace conddp
