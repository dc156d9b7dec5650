#pragma once

#include <string>
#include <string_view>

#include "ocp/problem/problem.hpp"
#include "solvers/common/options.hpp"
#include "solvers/common/solve_result.hpp"

namespace conddp {

/// Pattern of a solve's log.
enum class DiagnosisPattern {
  /// All residuals fell below their tolerances.
  normal,
  /// A number is not finite, or steps leave the finite numbers.
  growth,
  /// A stage problem has no minimum.
  indefinite,
  /// The violation of the constraints could not be lowered any further.
  infeasible,
  /// A violation remains, and it is not known whether the constraints can be satisfied.
  undecided,
  /// Further decrease is smaller than the rounding of the cost.
  rounding_floor,
  /// The contacts at the knot of a stalled solve depend on each other.
  redundant_contacts,
  /// The initial state lacks static equilibrium because torques are too weak (missing_torque()).
  no_static_equilibrium,
  /// The cost keeps falling, and nothing limits a control (free_control()).
  free_control,
  /// The gaps of the dynamics do not close.
  open_gaps,
  /// A cost that is linear in its residual falls by more than the constraint penalties rise.
  outrun_penalty,
  /// The violation falls slowly although full steps are taken.
  slow_feasibility,
  /// Stationarity has stalled with small or strongly regularized steps.
  plateau,
  /// No step lowers the merit.
  no_descent,
  /// The solve stopped while its residuals were still falling.
  unfinished,
};

/// Name in outputs: "normal", "open_gaps", ...
std::string_view to_string(DiagnosisPattern pattern);

/// Assessment of a solve from its log, with a suggestion.
struct Diagnosis {
  DiagnosisPattern pattern = DiagnosisPattern::normal;
  std::string message;   ///< one sentence with figures
  int knot = -1;         ///< the knot concerned, or −1
  std::string quantity;  ///< the quantity concerned: "stationarity", "gap", ...
  std::string remedy;    ///< suggestion; empty if none is needed
};

/// Diagnoses a solve from its log, status and options; at most the last ten rows count. If the
/// problem itself is the cause, the pattern is that cause, and the message still describes the log.
/// Such causes are contacts that depend on each other, a robot too weak to stand, a control that
/// nothing limits, and steps that are too long. A remedy names options with values that they
/// accept, and residuals above tolerance.
Diagnosis diagnose(const ShootingProblem& problem, const SolveResult& result,
                   const SolverOptions& options);

}  // namespace conddp
