#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/certificate/check.hpp"
#include "analysis/certificate/second_order.hpp"
#include "analysis/certificate/solution_claims.hpp"
#include "ocp/problem/node_values.hpp"

namespace conddp {

/// Gradient of the cost with respect to the controls, projected on the control bounds. States
/// follow from the controls, and constraints enter with the answer's multipliers. It is given in
/// two coordinate systems that are independent of the answer's co-states and gains. Both gradients
/// vanish at the same trajectories.
struct Optimality {
  /// Gradient with respect to v along a policy δu = v + K δx of the certificate (riccati_policy).
  /// This one decides, because the model's Hessian then consists of the blocks Q_uu, however
  /// unstable the motion is.
  double stationarity = Check::kNone;
  double rounding = Check::kNone;  ///< rounding of `stationarity` (AdjointPass::rounding)
  /// Gradient with respect to the controls themselves, by a plain adjoint pass. It grows as the
  /// free motion does.
  double reduced_gradient = Check::kNone;
  double reduced_rounding = Check::kNone;
  /// Cost decrease predicted by a Newton step with the Gauss-Newton model, the same in any
  /// coordinates.
  double expected_decrease = Check::kNone;
};

/// A figure of the optimality: its name in documents, and the effect of rounding on it.
struct OptimalityFigure {
  const char* name;
  double Optimality::*value;
  double Optimality::*rounding;  ///< null for 10⁻¹²
};
inline constexpr OptimalityFigure kOptimalityFigures[] = {
    {"stationarity", &Optimality::stationarity, &Optimality::rounding},
    {"rounding", &Optimality::rounding, &Optimality::rounding},
    {"reduced_gradient", &Optimality::reduced_gradient, &Optimality::reduced_rounding},
    {"reduced_rounding", &Optimality::reduced_rounding, &Optimality::reduced_rounding},
    {"expected_decrease", &Optimality::expected_decrease, nullptr}};

/// Verdict of a certificate on an answer.
enum class Verdict {
  contradicted,   ///< a claim of the answer does not hold
  consistent,     ///< all claims hold, but the answer did not converge
  local_minimum,  ///< converged, with positive curvature in every direction
  stationary,     ///< converged, with curvature that is zero to rounding in a direction
  not_a_minimum   ///< converged, with negative curvature: a saddle or a maximum
};

/// Checks of an answer's claims; the certificate holds if all of them do.
struct Certificate {
  std::vector<Check> checks;
  Optimality optimality;
  /// Only for an answer that claims convergence, in the unit of the file.
  std::optional<SecondOrder> second_order;
  std::string curvature;  ///< place and meaning of a negative or undecided curvature
  /// True if the answer claims convergence, is feasible, and is not found to be optimal.
  bool optimality_in_doubt = false;

  bool holds() const;
  int failures() const;
  Verdict verdict() const;
  /// True if the only failed checks are those that ill-conditioning blurs: optimality of the
  /// answer, and the sweep equation of its feedforward. The motion and its costs are then as
  /// claimed.
  bool doubts_optimality_alone() const;
  /// True if every failed check of a figure found a finite number. Otherwise, the failure says
  /// nothing about the answer.
  bool computable() const;
};

/// Judges an answer to a problem. Evaluates every knot in scalar arithmetic, compares costs, gaps,
/// bounds and multipliers with the claims, and computes the gradient of the Lagrangian by dual
/// numbers (lagrangian_gradient). No solver code takes part. docs/verification.md has the formulas
/// and tolerances.
Certificate certify(const ShootingProblem& problem, const SolutionClaims& claims);
/// The same, with given node values at the claimed trajectory.
Certificate certify(const ShootingProblem& problem, const SolutionClaims& claims,
                    const NodeValues& values);

/// Largest change that rounding can cause in constraint rows at a trajectory, relative to max(1,
/// |row|). It is measured by moving all states and controls so little that only rounding shows.
/// `values` are those at the trajectory.
double constraint_rounding(const ShootingProblem& problem, const Trajectory& trajectory,
                           const NodeValues& values);

/// True if the verdict rejects the answer: contradicted, or not a minimum.
inline bool is_denied(Verdict verdict) {
  return verdict == Verdict::contradicted || verdict == Verdict::not_a_minimum;
}
/// Name of a verdict in documents, such as "local_minimum".
std::string_view to_string(Verdict verdict);

}  // namespace conddp
