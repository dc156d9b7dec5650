#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "nlp/ipopt_options.hpp"
#include "nlp/nonlinear_program.hpp"
#include "nlp/symmetric_factorization.hpp"

namespace conddp {

/// A point with the multipliers of rows and bounds. In the Lagrangian f + rowsᵀ g − lowerᵀ y +
/// upperᵀ y, multipliers of bounds are nonnegative.
struct PrimalDualPoint {
  Eigen::VectorXd y, rows, lower, upper;
};

/// Ipopt's report of an iterate.
struct InteriorPointIterate {
  int iteration = 0;
  bool restoration = false;  ///< true while Ipopt seeks a feasible point, whatever the objective
  double objective = 0;
  double infeasibility = 0;       ///< largest violation of a row or bound
  double dual_infeasibility = 0;  ///< ∞-norm of the Lagrangian's gradient, in Ipopt's scaling
  double complementarity = 0;     ///< largest product of multiplier and slack, scaled
  double barrier = 0;             ///< μ
  double step = 0;                ///< step length of the variables
  double step_norm = 0;           ///< ‖δy‖∞
  double regularization = 0;      ///< added to the Hessian
  int trials = 0;                 ///< trials of the line search
  const double* y = nullptr;      ///< the variables
};

/// Outcome of an Ipopt solve, from the most to the least useful answer.
enum class InteriorPointEnd {
  solved,      ///< Ipopt's tolerances are met
  acceptable,  ///< looser tolerances are met, and rounding hides further progress
  stopped,     ///< the caller's callback stopped it
  max_iterations,
  time_limit,        ///< processor time of Ipopt's own option is used up
  infeasible,        ///< converged to a point of locally minimal violation
  no_step,           ///< the step is too small, or the restoration phase failed
  no_factorization,  ///< the step cannot be computed with any regularization
  diverging,         ///< iterates grow beyond all bounds
  not_finite,        ///< a value or derivative is not finite
  failed,            ///< anything else
};

struct InteriorPointAnswer {
  InteriorPointEnd end = InteriorPointEnd::failed;
  std::string message;  ///< Ipopt's reason in words
  PrimalDualPoint point;
  double barrier = 0;             ///< last μ
  double evaluation_seconds = 0;  ///< in the program's values and derivatives

  /// True if Ipopt's tolerances are met, including the looser ones.
  bool is_good() const {
    return end == InteriorPointEnd::solved || end == InteriorPointEnd::acceptable;
  }
};

/// Settings of a solve.
struct InteriorPointSettings {
  int max_iterations = 1000;
  /// Tolerances of Ipopt's scaled optimality error, and of its unscaled parts.
  double tolerance = 1e-8;
  double dual_tolerance = 1e-6, violation_tolerance = 1e-9, complementarity_tolerance = 1e-6;
  /// MUMPS orders systems by minimum fill and does not permute large entries to the diagonal first.
  /// Suits horizons, whose systems are banded, and singular where a bound is inactive.
  bool minimum_fill = false;
  /// Solves Ipopt's linear systems, unless the options name a linear solver or configure MUMPS, or
  /// this Ipopt lacks a slot for ours. If null, MUMPS solves them.
  MakeFactorization make_factorization = nullptr;
  /// Ipopt's own options, which override the settings above.
  IpoptOptions options;
  /// Multipliers and barrier of an earlier solve to continue from, if any.
  const PrimalDualPoint* warm = nullptr;
  double warm_barrier = 0;
  /// Distance by which a warm start pushes variables and slacks off their bounds. It is small: a
  /// continued solve should stay where it is.
  double warm_push = 1e-9;
};

/// Minimizes a nonlinear program by Ipopt from a point. `on_iterate` receives every iterate and
/// returns whether to continue. Options with a bad name or value throw std::invalid_argument.
/// Neither reads nor writes files, and prints nothing. Solves in one process wait for each other:
/// Ipopt's linear solver MUMPS is not thread-safe.
InteriorPointAnswer minimise(NonlinearProgram& program, const Eigen::VectorXd& start,
                             const InteriorPointSettings& settings,
                             const std::function<bool(const InteriorPointIterate&)>& on_iterate);

/// Multipliers of a program's rows at its current point with the least Σ weight_i (∂L/∂y_i)², plus
/// the squared distances of inequality multipliers from 1. Bounds of variables have multipliers of
/// 1. `weights`: positive, by variable. Empty if derivatives are not finite, or the rows do not
/// determine the multipliers.
std::optional<Eigen::VectorXd> first_multipliers(NonlinearProgram& program,
                                                 const Eigen::VectorXd& weights,
                                                 MakeFactorization make_factorization);

}  // namespace conddp
