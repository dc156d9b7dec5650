#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "solvers/riccati/segment_sweep.hpp"
#include "solvers/stages/stage_sweep.hpp"

namespace conddp {

/// The Riccati sweep of every DDP solver: from the last node to the first it prepares the next
/// value (gap), lets a solver minimise the stage with regularised second derivatives, and forms the
/// value of the resulting policy with the true ones, which also holds where controls are clamped:
///   V_x  = Q_x + Kᵀ Q_uu k + Kᵀ Q_u + Q_xu k,
///   V_xx = Q_xx + Kᵀ Q_uu K + Kᵀ Q_ux + Q_xu K.
/// Without regularisation the rows of Q_uu K + Q_ux that K does not leave out are zero: then
///   V_xx = Q_xx + Kᵀ Q_ux.
///
/// With several segments, sweeps whose policy is affine go by them (SegmentSweep): those without
/// regularisation that hold their active set, or have no bounds on the control. The policies' steps
/// through the linear model are the same; gains and values before the last segment belong to values
/// at the ends of segments that are near the true ones.
class BackwardSweep {
 public:
  BackwardSweep(const ShootingProblem& problem, const ControlBounds& bounds,
                Segments segments = {});

  /// Fills `feedback`, for the full step that closes the gaps. Returns the knot
  /// whose stage has no minimum or is not finite, or −1 where all went well. `hold`: see
  /// ActiveSet::begin_sweep. With `from` the sweep begins at that knot: what stands behind it is as
  /// the sweep before saw it, and so are its values and its part of `feedback`.
  int run(const Linearization& linearization, const Trajectory& trajectory, const Gaps& gaps,
          SweepRegularization regularization, StageSolver& stages, Feedback& feedback,
          bool hold = false, std::optional<int> from = {});

  /// Value at node k after a sweep, with respect to δx_k.
  const ValueFunction& value(int k) const { return values_[k]; }
  /// Q_uu of a knot, without regularisation.
  const Eigen::MatrixXd& Quu(int k) const { return Quu_[k]; }

  /// Exchanges the memory of values with another problem's, before both are swept again.
  void exchange_memory(BackwardSweep& other);

  /// Whether sweeps may go by segments, where there are several.
  void use_segments(bool use) { use_segments_ = use; }

 private:
  void start_at_end(const Linearization& linearization, SweepRegularization regularization);
  int sweep_from(int knot, const SweptHorizon& horizon, SweepRegularization regularization,
                 StageSolver& stages, Feedback& feedback);
  bool pass_stage(int knot, const SweptHorizon& horizon, SweepRegularization regularization,
                  StageSolver& stages, Feedback& feedback);
  bool goes_by_segments(bool hold, const SweepRegularization& regularization) const;

  const ControlBounds& bounds_;
  std::vector<ValueFunction> values_;  ///< N + 1
  std::vector<Eigen::MatrixXd> Quu_;
  StageSweep stage_;
  std::unique_ptr<SegmentSweep> segments_;  ///< where there are several
  bool bounded_, use_segments_ = true;
};

}  // namespace conddp
