#pragma once

#include <string>
#include <vector>

#include "ocp/evaluation/evaluator.hpp"

namespace conddp {

/// Kind of a derivative.
enum class DerivativeKind {
  dynamics,    ///< ∂x⁺/∂z of a knot, rows in the tangent space of the next state
  residual,    ///< ∂r/∂z of one cost's residual
  constraint,  ///< ∂g/∂z of one constraint
  gradient,    ///< ∇_z of a knot's cost, one row
  hessian      ///< ∇²_z of a knot's Lagrangian with random multipliers
};

/// Comparison of a derivative of a phase with its reference, at the entry with the largest error. z
/// = (tangent at x, u); the rows of a Hessian are z, too.
struct DerivativeComparison {
  DerivativeKind kind = DerivativeKind::dynamics;
  int phase = 0;            ///< index; the number of phases stands for the terminal node
  int term = -1;            ///< residual or constraint of the knot model, the first of its name
  std::vector<int> knots;   ///< knots of the comparison
  long long entries = 0;    ///< numbers compared
  int row = 0, column = 0;  ///< worst entry
  int knot = 0;             ///< knot of the worst entry
  bool displaced = false;   ///< true if it lies on the displaced trajectory
  double analytic = 0;      ///< value that solvers get
  double reference = 0;     ///< by dual numbers; for a Hessian by differences
  double error = 0;         ///< relative, see check_derivatives
};

/// Largest relative error of a correct derivative.
inline constexpr double kDerivativeTolerance = 1e-6;

struct DerivativeCheckOptions {
  /// Number of compared knots per phase: the first, the last, and some between.
  int knots_per_phase = 3;
  /// Largest entry of the random tangent vectors that displace a second trajectory from the given
  /// one; 0 skips it. Entries for controls are relative to their size if that is above 1. At rest
  /// or on a reference, many derivatives vanish, right or wrong.
  double displacement = 0.1;
  unsigned seed = 1;
};

/// Compares all first derivatives that solvers use with derivatives by dual numbers. The latter go
/// through evaluation alone and share no formula with the former. Derivatives of compiled functions
/// rest on differences of their values (LibraryKnotFunction::evaluate).
///
/// If such a function claims second derivatives, Hessians are compared as well. Their reference is
/// central differences of gradients, which lose up to 10⁻⁴ of an entry. This comparison uses only
/// the displaced trajectory, because costs may have kinks where nothing is random.
///
/// An error is relative to the larger of the two numbers, but at least to a thousandth of the
/// largest entry of its matrix. That entry counts as 1 at least, or for gradients as the sum of the
/// weights. Smaller numbers are rounding. The error is infinite if either number is not finite.
/// Displaced points without finite values at a knot are left out.
std::vector<DerivativeComparison> check_derivatives(const ShootingProblem& problem,
                                                    const Trajectory& trajectory,
                                                    const DerivativeCheckOptions& options = {});

}  // namespace conddp
