#pragma once

#include <string>
#include <string_view>

#include "ocp/problem/problem.hpp"
#include "solvers/common/options.hpp"
#include "solvers/common/solve_result.hpp"

namespace conddp {

/// What the log of a solve looks like.
enum class DiagnosisPattern {
  /// All residuals came under their tolerances.
  normal,
  /// A number is not finite, or steps leave the finite numbers.
  growth,
  /// A stage problem has no minimum.
  indefinite,
  /// No way was found to lower the violation of the constraints any further.
  infeasible,
  /// A violation stays, and it is not known whether the constraints can be satisfied.
  undecided,
  /// Further decrease is smaller than the rounding of the cost.
  rounding_floor,
  /// The contacts of the knot at which the solve stalls depend on each other.
  redundant_contacts,
  /// The initial state lacks static equilibrium for want of torque (missing_torque()).
  no_static_equilibrium,
  /// The cost goes on falling, and nothing holds a control back (free_control()).
  free_control,
  /// The gaps of the dynamics do not close.
  open_gaps,
  /// A cost that is linear in its residual falls by more than the penalties of constraints rise.
  outrun_penalty,
  /// Constraints are approached slowly although full steps are taken.
  slow_feasibility,
  /// Controls keep coming to their bounds and leaving them.
  alternating_active_set,
  /// Stationarity has stalled while steps are small or strongly regularised.
  plateau,
  /// No step lowers the merit.
  no_descent,
  /// The solve stopped while its residuals were still falling.
  unfinished,
};

/// The name as it stands in outputs: "normal", "open_gaps", ...
std::string_view to_string(DiagnosisPattern pattern);

/// What a log says about how the solve went, and what to try.
struct Diagnosis {
  DiagnosisPattern pattern = DiagnosisPattern::normal;
  std::string message;   ///< one sentence with figures
  int knot = -1;         ///< the knot concerned, −1: none in particular
  std::string quantity;  ///< the quantity concerned: "stationarity", "gap", ...
  std::string remedy;    ///< what to try, empty where nothing has to be
};

/// Reads it off the log, the status and the options; the rows at the end count, ten at most. Where
/// the problem itself has a reason (contacts that depend on each other, a robot too weak to stand,
/// a control that nothing holds back, steps that are too long) the pattern is that reason, and the
/// message says what the log looks like all the same. A remedy names options with values that they
/// accept, and residuals that are above tolerance.
Diagnosis diagnose(const ShootingProblem& problem, const SolveResult& result,
                   const SolverOptions& options);

}  // namespace conddp
