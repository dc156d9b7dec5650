#pragma once

#include "ocp/problem/augmentation.hpp"

namespace conddp {

/// Treatment of gaps and bounds in a rollout.
struct RolloutOptions {
  bool contract_gaps = false;   ///< x_{k+1} = f ⊕ (α − 1) gap instead of f (multiple shooting)
  bool clamp_controls = false;  ///< clamp every control to its bounds
  const Augmentation* augmentation = nullptr;  ///< added to the cost
};

}  // namespace conddp
