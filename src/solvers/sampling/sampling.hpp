#pragma once

#include "solvers/sampling/rollout_values.hpp"
#include "solvers/sampling/sampling_options.hpp"

namespace conddp {

/// The best rollout.
struct SampledTrajectory {
  Trajectory trajectory;
  RolloutValue value;
  int rollouts = 0;   ///< evaluated
  int discarded = 0;  ///< those that are not finite
  /// False if no finite rollout is better than that of the nominal, which is the trajectory then.
  bool found = false;
};

/// Searches the parameters of control splines by rollouts, the nominal one first. The same seed
/// gives the same answer for every number of threads.
///
/// The score of a sample in round r is a + max(1, r²/4) b (dynamic penalties: Joines, Houck 1994),
/// with a the cost above the least one, divided by that of the median, and b the violation, divided
/// by the median of the violating samples: weights of penalties follow from the samples (Lemonge,
/// Barbosa 2004).
SampledTrajectory search_controls(const ControlSplines& splines, const SamplingOptions& options,
                                  const Simulate& simulate = nullptr);

}  // namespace conddp
