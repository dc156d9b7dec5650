#pragma once

#include <optional>
#include <vector>

#include "solvers/stages/stage_sweep.hpp"

namespace conddp {

/// The Riccati sweep of every DDP solver, from the last node to the first. At each knot it carries
/// the next value across the gap and lets a solver minimize the stage. It then forms the value of
/// the resulting policy, in a form that also holds for clamped controls:
///   V_x  = Q_x + Kᵀ Q_uu k + Kᵀ Q_u + Q_xu k,
///   V_xx = Q_xx + Kᵀ Q_uu K + Kᵀ Q_ux + Q_xu K.
/// If K minimizes the stage, the rows of Q_uu K + Q_ux that K does not leave out are zero; then
///   V_xx = Q_xx + Kᵀ Q_ux.
class BackwardSweep {
 public:
  BackwardSweep(const ShootingProblem& problem, const ControlBounds& bounds);

  /// Fills `feedback` for the full step, which closes the gaps. Returns the knot of a stage that is
  /// not finite or lacks a minimum, or −1 on success. `regularization`: the weight μ of
  /// SolverOptions::Regularization. `hold`: see ActiveSet::begin_sweep. With `from`, the sweep
  /// begins at that knot: everything behind it is taken as in the previous sweep, including the
  /// values and `feedback` there.
  int run(const Linearization& linearization, const Trajectory& trajectory, const Gaps& gaps,
          double regularization, StageSolver& stages, Feedback& feedback, bool hold = false,
          std::optional<int> from = {});

  /// Value at node k after a sweep, with respect to δx_k.
  const ValueFunction& value(int k) const { return values_[k]; }
  /// Unregularized Q_uu of a knot.
  const Eigen::MatrixXd& Quu(int k) const { return Quu_[k]; }

  /// Exchanges the memory of values with another problem's sweep, before both run again.
  void exchange_memory(BackwardSweep& other);

 private:
  void start_at_end(const Linearization& linearization, double regularization);
  int sweep_from(int knot, const SweptHorizon& horizon, double regularization, StageSolver& stages,
                 Feedback& feedback);
  bool pass_stage(int knot, const SweptHorizon& horizon, double regularization, StageSolver& stages,
                  Feedback& feedback);

  const ControlBounds& bounds_;
  std::vector<ValueFunction> values_;  ///< N + 1
  std::vector<Eigen::MatrixXd> Quu_;
  StageSweep stage_;
};

}  // namespace conddp
