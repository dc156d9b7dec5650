#pragma once

#include "solvers/iterate/hessian_switch.hpp"

namespace conddp {

/// Updates of multipliers and penalties at the end of a minimization.
enum class MultiplierSchedule {
  /// Multipliers always; the penalty if the violation has not fallen enough (ALTRO).
  always,
  /// A bound-constrained Lagrangian (Conn, Gould, Toint 1991; Jallet et al. 2025): updates
  /// multipliers if their change is within a tolerance, which then tightens. Otherwise the penalty
  /// grows and the multipliers stay.
  bound_constrained_lagrangian,
  /// A sweep computes the multipliers along with its step; penalties affect only the merit.
  by_the_sweep,
};

/// Choices that define one solver of the family.
struct DdpRecipe {
  bool open_gaps = false;       ///< multiple shooting: starts from the given states and contracts
                                ///< gaps
  bool clamp_controls = false;  ///< the rollout projects every control onto its bounds
  bool box_stage = false;       ///< stage problems respect the bounds
  bool constraints = false;     ///< constraints enter as an augmented Lagrangian
  MultiplierSchedule multipliers = MultiplierSchedule::always;
  bool least_violation = false;  ///< seeks a point of least violation
  bool newton = false;           ///< a projected Newton method ends the solve
  /// Second derivatives. With `when_slow`, the options decide or, if these are automatic, the solve
  /// does. Exact derivatives wait until the gaps are closed.
  HessianUse hessian = HessianUse::gauss_newton;
};

}  // namespace conddp
