#pragma once

#include "solvers/augmented_lagrangian.hpp"
#include "solvers/hessian_switch.hpp"

namespace conddp {

/// The choices that make one solver of the family.
struct DdpRecipe {
  bool open_gaps = false;       ///< multiple shooting: start from the states given, contract gaps
  bool clamp_controls = false;  ///< the rollout projects every control on its bounds
  bool box_stage = false;       ///< stage problems respect the bounds
  bool constraints = false;     ///< constraints enter as an augmented Lagrangian
  MultiplierSchedule multipliers = MultiplierSchedule::always;
  bool least_violation = false;  ///< what is looked for is a point of least violation
  bool newton = false;           ///< which a projected Newton method ends
  bool legs = false;             ///< sweeps may go by legs
  /// Exact second derivatives wait until the gaps are closed.
  HessianUse hessian = HessianUse::gauss_newton;
};

}  // namespace conddp
