#pragma once

#include "solvers/iterate/hessian_switch.hpp"

namespace conddp {

/// When multipliers change and when penalties grow, at the end of a minimisation.
enum class MultiplierSchedule {
  /// Multipliers always; the penalty where the violation has not fallen enough (ALTRO).
  always,
  /// A bound-constrained Lagrangian (Conn, Gould, Toint 1991; Jallet et al. 2025): multipliers
  /// where the change that they ask for is within a tolerance, which then gets tighter; elsewhere
  /// the penalty grows and they stay.
  bound_constrained_lagrangian,
  /// A sweep gives the multipliers along with its step; penalties belong to the merit alone.
  by_the_sweep,
};

/// The choices that make one solver of the family.
struct DdpRecipe {
  bool open_gaps = false;       ///< multiple shooting: start from the states given, contract gaps
  bool clamp_controls = false;  ///< the rollout projects every control on its bounds
  bool box_stage = false;       ///< stage problems respect the bounds
  bool constraints = false;     ///< constraints enter as an augmented Lagrangian
  MultiplierSchedule multipliers = MultiplierSchedule::always;
  bool least_violation = false;  ///< what is looked for is a point of least violation
  bool newton = false;           ///< which a projected Newton method ends
  bool segments = false;         ///< sweeps may go by segments of the horizon
  /// Which second derivatives; `when_slow` leaves it to the options and, where these do not say, to
  /// the solve. Exact ones wait until the gaps are closed.
  HessianUse hessian = HessianUse::gauss_newton;
};

}  // namespace conddp
