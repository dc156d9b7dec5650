#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "nlp/ipopt_options.hpp"
#include "nlp/nonlinear_program.hpp"
#include "nlp/symmetric_factorization.hpp"

namespace conddp {

/// A point with the multipliers of rows and bounds. In the Lagrangian f + rowsᵀ g − lowerᵀ y +
/// upperᵀ y those of bounds are not negative.
struct PrimalDualPoint {
  Eigen::VectorXd y, rows, lower, upper;
};

/// What Ipopt says of an iterate.
struct InteriorPointIterate {
  int iteration = 0;
  bool restoration = false;  ///< it looks for a feasible point, whatever the objective
  double objective = 0;
  double infeasibility = 0;       ///< largest violation of a row or bound
  double dual_infeasibility = 0;  ///< ∞-norm of the Lagrangian's gradient, scaled as Ipopt does
  double complementarity = 0;     ///< largest multiplier times slack, scaled
  double barrier = 0;             ///< μ
  double step = 0;                ///< of the variables
  double step_norm = 0;           ///< ‖δy‖∞
  double regularization = 0;      ///< added to the Hessian
  int trials = 0;                 ///< of the line search
  const double* y = nullptr;      ///< the variables
};

/// How Ipopt ended, in the order of what an answer is worth.
enum class InteriorPointEnd {
  solved,      ///< its tolerances hold
  acceptable,  ///< its looser tolerances hold, and rounding hides further progress
  stopped,     ///< the caller's callback stopped it
  max_iterations,
  time_limit,        ///< of processor time, by its own option
  infeasible,        ///< it converged to a point of locally least violation
  no_step,           ///< the step is too small, or the restoration phase failed
  no_factorization,  ///< the step cannot be computed, whatever the regularisation
  diverging,         ///< iterates grow beyond all bounds
  not_finite,        ///< a value or derivative is not finite
  failed,            ///< anything else
};

struct InteriorPointAnswer {
  InteriorPointEnd end = InteriorPointEnd::failed;
  std::string message;  ///< Ipopt's reason in words
  PrimalDualPoint point;
  double barrier = 0;             ///< last μ
  double evaluation_seconds = 0;  ///< of the program's values and derivatives

  /// Whether Ipopt's tolerances hold, be it its looser ones.
  bool is_good() const {
    return end == InteriorPointEnd::solved || end == InteriorPointEnd::acceptable;
  }
};

/// What a solve is told besides the program.
struct InteriorPointSettings {
  int max_iterations = 1000;
  /// Of Ipopt's scaled optimality error, and of its parts without scaling.
  double tolerance = 1e-8;
  double dual_tolerance = 1e-6, violation_tolerance = 1e-9, complementarity_tolerance = 1e-6;
  /// MUMPS orders systems by minimum fill and as they are, without permuting large entries to the
  /// diagonal first: for horizons, whose systems are bands, and singular where a bound rests.
  bool minimum_fill = false;
  /// Solves Ipopt's linear systems, unless its options name a linear solver or are of MUMPS, or
  /// this Ipopt has no place for one of ours. Without it MUMPS does.
  MakeFactorization make_factorization = nullptr;
  /// Ipopt's own options, which go before what is above.
  IpoptOptions options;
  /// The multipliers and the barrier of an earlier solve to go on from, if there is one.
  const PrimalDualPoint* warm = nullptr;
  double warm_barrier = 0;
  /// How far variables and slacks are pushed from their bounds then: one that goes on should stay
  /// where it is.
  double warm_push = 1e-9;
};

/// Minimises a nonlinear program by Ipopt from a point. `on_iterate` is told of every iterate and
/// returns whether to go on. Options with a bad name or value throw std::invalid_argument. No file
/// is read or written and nothing printed. Solves in one process wait for each other: Ipopt's
/// linear solver MUMPS is not made for threads.
InteriorPointAnswer minimise(NonlinearProgram& program, const Eigen::VectorXd& start,
                             const InteriorPointSettings& settings,
                             const std::function<bool(const InteriorPointIterate&)>& on_iterate);

}  // namespace conddp
