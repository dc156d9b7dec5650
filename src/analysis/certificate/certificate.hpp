#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/certificate/check.hpp"
#include "analysis/certificate/second_order.hpp"
#include "analysis/certificate/solution_claims.hpp"
#include "ocp/problem/node_values.hpp"

namespace conddp {

/// The gradient of the cost by the controls where states follow from them, with the multipliers
/// that an answer has of its constraints, projected on the control bounds: in two systems of
/// coordinates, neither of which knows the answer's own co-states and gains. Either is zero at the
/// same trajectories.
struct Optimality {
  /// Along a policy δu = v + K δx of the certificate's own (riccati_policy), by v. This decides:
  /// there the model's Hessian consists of the blocks Q_uu, however unstable the motion is.
  double stationarity = Check::kNone;
  double rounding = Check::kNone;  ///< of it (AdjointPass::rounding)
  /// By the controls themselves, a plain adjoint: it grows as the free motion does.
  double reduced_gradient = Check::kNone;
  double reduced_rounding = Check::kNone;
  /// By how much a step of Newton's method with the Gauss-Newton model would lower the cost, the
  /// same in any coordinates.
  double expected_decrease = Check::kNone;
};

/// What a certificate says of an answer in a word.
enum class Verdict {
  contradicted,   ///< a statement of the answer does not hold
  consistent,     ///< all hold, of an answer that did not converge
  local_minimum,  ///< converged, with positive curvature in every direction
  stationary,     ///< converged, with curvature that is zero to rounding in a direction
  not_a_minimum   ///< converged, with negative curvature: a saddle or a maximum
};

/// The statements of an answer that were checked; it holds where all of them do.
struct Certificate {
  std::vector<Check> checks;
  Optimality optimality;
  /// Of an answer that claims to have converged, in the unit of the file.
  std::optional<SecondOrder> second_order;
  std::string curvature;  ///< where it is negative or undecided, and what that means
  /// Whether the answer claims to have converged, is feasible, and is not found to be optimal.
  bool optimality_in_doubt = false;

  bool holds() const;
  int failures() const;
  Verdict verdict() const;
  /// Whether all that fails is what an ill-conditioned problem blurs: that the answer is optimal,
  /// and that its feedforward solves the equation of a sweep. What the motion is and costs holds.
  bool doubts_optimality_alone() const;
  /// Whether all figures that were checked are finite. Where numbers left the finite ones on the
  /// way to them, a check that fails says nothing of whoever made the claim.
  bool computable() const;
};

/// The model of second order of the answer that was judged last, for another certificate of the
/// same numbers in the same process. May be used by several threads.
class SecondOrderMemory {
 public:
  void keep(const SolutionClaims& claims, const SecondOrder& found);
  /// None where the claims are others.
  std::optional<SecondOrder> of(const SolutionClaims& claims) const;

 private:
  mutable std::mutex guard_;
  Trajectory trajectory_;
  Eigen::VectorXd multipliers_;
  std::optional<SecondOrder> found_;
};

/// Judges an answer to a problem: evaluates every knot in scalar arithmetic, compares costs, gaps,
/// bounds and multipliers with what is claimed, and the gradient of the Lagrangian by dual numbers
/// (lagrangian_gradient). Nothing of the solvers has a part in it. docs/verification.md has the
/// formulas and tolerances.
Certificate certify(const ShootingProblem& problem, const SolutionClaims& claims);
/// The same with the values of the nodes at the trajectory that is claimed, and with what is known
/// of these numbers.
Certificate certify(const ShootingProblem& problem, const SolutionClaims& claims,
                    const NodeValues& values, const SecondOrderMemory* known = nullptr);

/// What rounding can change in the values of constraint rows at a trajectory, relative to them or
/// to 1: from all states and controls moved so little that only rounding shows. `values` are those
/// at the trajectory.
double constraint_rounding(const ShootingProblem& problem, const Trajectory& trajectory,
                           const NodeValues& values);

/// Whether an answer is none: contradicted, or no minimum.
inline bool is_denied(Verdict verdict) {
  return verdict == Verdict::contradicted || verdict == Verdict::not_a_minimum;
}
/// The word that documents have for a verdict: "local_minimum", ...
std::string_view to_string(Verdict verdict);

}  // namespace conddp
