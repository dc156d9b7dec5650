#include "solvers/riccati/backward_sweep.hpp"

#include <algorithm>

#include "ocp/evaluation/checkpoint.hpp"
#include "solvers/linalg/exchange.hpp"

namespace conddp {

BackwardSweep::BackwardSweep(const ShootingProblem& problem, const ControlBounds& bounds)
    : bounds_(bounds), values_(problem.knots() + 1, ValueFunction(problem.ndx())), stage_(problem) {
  for (int k = 0; k < problem.knots(); ++k) Quu_.emplace_back(problem.nu(k), problem.nu(k));
}

/// Sets the value at the last node.
void BackwardSweep::start_at_end(const Linearization& linearization, double regularization) {
  const int N = bounds_.knots();
  values_[N].Vx = linearization.knots[N].gradient;
  values_[N].Vxx = linearization.knots[N].hessian();
  if (regularization > 0) values_[N].Vxx.diagonal().array() += regularization;
}

inline bool BackwardSweep::pass_stage(int k, const SweptHorizon& horizon, double regularization,
                                      StageSolver& stages, Feedback& feedback) {
  stage_.propagate(horizon, k, values_[k + 1]);
  Quu_[k] = stage_.q().Quu();
  if (!stage_.solve(horizon, k, regularization, stages, feedback)) return false;
  return stage_.form_value(values_[k], feedback.k[k], stages.minimizes_freely());
}

/// Sweeps from a knot to the first one. Returns the knot that fails, or −1.
inline int BackwardSweep::sweep_from(int knot, const SweptHorizon& horizon, double regularization,
                                     StageSolver& stages, Feedback& feedback) {
  const int N = bounds_.knots();
  for (int k = knot; k >= 0; --k) {
    if ((N - k) % kKnotsBetweenCheckpoints == 0) pass_checkpoint();
    if (!pass_stage(k, horizon, regularization, stages, feedback)) return k;
  }
  return -1;
}

int BackwardSweep::run(const Linearization& linearization, const Trajectory& trajectory,
                       const Gaps& gaps, double regularization, StageSolver& stages,
                       Feedback& feedback, bool hold, std::optional<int> from) {
  const int N = bounds_.knots();
  const SweptHorizon horizon{linearization, trajectory, gaps, bounds_};
  stages.begin_horizon(linearization, gaps);
  stages.active_set().begin_sweep(hold);
  if (!from) start_at_end(linearization, regularization);
  return sweep_from(from.value_or(N - 1), horizon, regularization, stages, feedback);
}

void BackwardSweep::exchange_memory(BackwardSweep& other) {
  for (std::size_t k = 0; k < std::min(values_.size(), other.values_.size()); ++k)
    exchange(values_[k].Vxx, other.values_[k].Vxx);
  exchange(Quu_, other.Quu_);
}

}  // namespace conddp
