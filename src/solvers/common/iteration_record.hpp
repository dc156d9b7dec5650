#pragma once

namespace conddp {

/// One row of the log: an iterate and the step that led to it. Row 0 is the start, with zero step
/// columns.
struct IterationRecord {
  int iteration = 0;              ///< accepted steps so far
  double cost = 0;                ///< J
  double merit = 0;               ///< J + penalty · Σ‖gap‖₁ + augmentation
  double stationarity = 0;        ///< ‖∇_u L‖∞, projected on the control bounds
  int stationarity_knot = -1;     ///< where it is attained
  double gap = 0;                 ///< max ‖f(x_k, u_k) ⊖ x_{k+1}‖∞
  int gap_knot = -1;              ///< where it is attained
  double constraint = 0;          ///< largest violation of a constraint or control bound
  int constraint_knot = -1;       ///< where it is attained
  double complementarity = 0;     ///< largest product of a multiplier and the distance from its
                                  ///< bound
  double constraint_penalty = 0;  ///< largest penalty of the augmented Lagrangian
  int newton = 0;                 ///< projected Newton steps so far
  int active_rows = 0;            ///< active rows of such a step
  int outer = 0;                  ///< multiplier updates so far
  double step = 0;                ///< accepted step length α
  double regularization = 0;      ///< of the sweep that gave the step
  bool exact_hessian = false;     ///< true if that sweep used exact second derivatives
  double penalty = 0;             ///< weight ν of the gaps in the merit
  double expected_decrease = 0;   ///< of the merit, to first order
  double actual_decrease = 0;     ///< of the merit
  int trials = 0;                 ///< step lengths tried, over all regularizations
  int sweeps = 0;              ///< backward passes begun, over all regularizations and active sets
  int clamped_controls = 0;    ///< control entries held at a bound by the stage problems
  int active_set_changes = 0;  ///< changes of their states in the last sweep
  double barrier = 0;          ///< parameter μ of an interior-point method
  double relaxation = 0;       ///< ε of relaxed complementarity
  int fallbacks = 0;           ///< relaxations given up so far
  double homotopy = 1;         ///< homotopy parameter; 1 is the problem itself
  int restoration = 0;         ///< number of the restoration of feasibility, 0 outside of
                               ///< restorations
  double time_s = 0;           ///< since the start of the solve
};

}  // namespace conddp
