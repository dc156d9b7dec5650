#pragma once

#include "ocp/problem/augmentation.hpp"

namespace conddp {

/// How a rollout treats gaps and bounds.
struct RolloutOptions {
  bool contract_gaps = false;   ///< x_{k+1} = f ⊕ (α − 1) gap instead of f (multiple shooting)
  bool clamp_controls = false;  ///< project every control on its bounds
  const Augmentation* augmentation = nullptr;  ///< added to the cost
};

}  // namespace conddp
