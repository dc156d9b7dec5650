#pragma once

#include <string>
#include <vector>

#include "ocp/evaluation/evaluator.hpp"

namespace conddp {

/// What a derivative is one of.
enum class DerivativeKind {
  dynamics,    ///< ∂x⁺/∂z of a knot, rows in the tangent space of the next state
  residual,    ///< ∂r/∂z of one cost's residual
  constraint,  ///< ∂g/∂z of one constraint
  gradient,    ///< ∇_z of a knot's cost, one row
  hessian      ///< ∇²_z of a knot's Lagrangian with random multipliers
};

/// A derivative of a phase, compared with the reference: the entry that is furthest off.
/// z = (tangent at x, u); the rows of a Hessian are z, too.
struct DerivativeComparison {
  DerivativeKind kind = DerivativeKind::dynamics;
  int phase = 0;            ///< index; the number of phases stands for the terminal node
  int term = -1;            ///< of a residual or constraint: index into those of the knot
                            ///< model, the first of its name
  std::vector<int> knots;   ///< at which it was compared
  long long entries = 0;    ///< numbers compared
  int row = 0, column = 0;  ///< of the worst entry
  int knot = 0;             ///< where that is
  bool displaced = false;   ///< whether it is beside the trajectory
  double analytic = 0;      ///< what solvers get
  double reference = 0;     ///< by dual numbers; of a Hessian by differences
  double error = 0;         ///< relative, see check_derivatives
};

/// Largest relative error of a derivative that is right.
inline constexpr double kDerivativeTolerance = 1e-6;

struct DerivativeCheckOptions {
  /// Knots of a phase at which derivatives are compared: the first, the last, and some between.
  int knots_per_phase = 3;
  /// Largest entry of the random tangent vectors by which a second trajectory lies beside the given
  /// one (controls: relative to their size where that is above 1); 0: none. At rest or on a
  /// reference many derivatives vanish, right or wrong.
  double displacement = 0.1;
  unsigned seed = 1;
};

/// Compares all first derivatives that solvers use with derivatives by dual numbers through
/// evaluation alone, which share no formula with them. Those of compiled functions rest on
/// differences of their values (LibraryKnotFunction::evaluate). Where such a function claims second
/// derivatives, Hessians are compared, too, with central differences of gradients, which lose up to
/// 10⁻⁴ of an entry; beside the trajectory alone, because costs may bend where nothing is random.
/// An error is relative to the larger of the two numbers, but at least to a thousandth of the
/// largest entry of its matrix (and of 1; of the weights, for gradients), below which lies
/// rounding. It is infinite where one of the two is not finite. A point beside the trajectory at
/// which a knot has no finite values is left out.
std::vector<DerivativeComparison> check_derivatives(const ShootingProblem& problem,
                                                    const Trajectory& trajectory,
                                                    const DerivativeCheckOptions& options = {});

}  // namespace conddp
