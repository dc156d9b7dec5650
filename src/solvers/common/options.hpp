#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "nlp/ipopt_options.hpp"
#include "nlp/relaxed_rows.hpp"
#include "solvers/common/dual_guess.hpp"
#include "solvers/common/iteration_record.hpp"

namespace conddp {

class ShootingProblem;

/// Problems along a homotopy by their share of the way, in [0, 1]. All have one shape; the one at 1
/// is the problem to solve. Returns null if a problem cannot be built. May be called from several
/// threads.
using ProblemPath = std::function<std::shared_ptr<const ShootingProblem>(double share)>;

/// Second derivatives in the sweep. With `automatic`, the solver chooses: exact for ddp,
/// Gauss-Newton for ilqr and ilqr_clip. The others use Gauss-Newton with L-BFGS corrections until
/// exact derivatives pay (docs/solvers.md).
enum class HessianChoice { automatic, gauss_newton, exact };

/// All options of a DDP solve. The defaults serve the whole catalogue.
/// solvers/common/option_table.hpp lists the same options by name, with a range and a sentence
/// each.
struct SolverOptions {
  int max_iterations = 1000;
  double max_time_s = std::numeric_limits<double>::infinity();
  int threads = 1;
  HessianChoice hessian = HessianChoice::automatic;

  struct Tolerances {
    double stationarity = 1e-6;
    double gap = 1e-9;
    double constraint = 1e-6;
    double complementarity = 1e-6;
    double cost_decrease = 0;
  } tolerances;

  /// The weight μ of ½ μ (‖δx‖² + ‖δu‖²) in the model's cost at every node: a Levenberg-Marquardt
  /// term that keeps the whole trajectory near the iterate and enters the value function. Far-away
  /// starts converge more often than with weights that change the gains alone
  /// (docs/measurements/ablations.md).
  struct Regularization {
    /// At this weight, a gradient of 1 moves a variable by 1e-10 only.
    static constexpr double kLargest = 1e10;
    double initial = 0;
  } regularization;

  /// For solvers that minimize an augmented Lagrangian.
  struct AugmentedLagrangian {
    double initial_penalty = 0.1;
    double penalty_factor = 10;
    double max_penalty = 1e8;
    double sufficient_decrease = 0.25;
  } augmented_lagrangian;

  /// For complementary pairs in the solver `ipopt`.
  struct Complementarity {
    /// The last epsilon: z s ≤ ε leaves min(z, s) ≤ 1e-6, the usual tolerance of constraints.
    static constexpr double kLast = 1e-12;
    PairRelaxation relaxation = PairRelaxation::elementwise;
    double initial = 0.01;
  } complementarity;

  /// Further solves from random perturbations of the guess; the best answer is returned.
  struct Restarts {
    int count = 0;
    int seed = 0;
    double spread = 0.1;
  } restarts;

  /// solve_best looks for a better answer until its iterations reach this amount of work
  /// (look_further.cpp).
  int look_further = 5000000;

  /// Ipopt's own options by name, for the solver `ipopt`.
  IpoptOptions ipopt;

  /// Initial multipliers in addition to the guess, for solvers with multipliers of constraints.
  std::shared_ptr<const DualGuess> multipliers;

  /// Homotopy that leads to the answer; null to solve the problem at once.
  ProblemPath homotopy;

  /// Called with every row of the log as soon as it is known; the row is valid only during the
  /// call. With restarts, called with the rows of the first start only.
  std::function<void(const IterationRecord&)> on_iteration;
  /// Called once per iteration and regularization; true ends the solve with status `interrupted`.
  /// Restarts call it from several threads, but never concurrently, and never during a call of
  /// `on_iteration`.
  std::function<bool()> interrupted;

  /// One message for each option that is out of range, naming the option; empty if all are valid.
  /// Values are never replaced.
  std::vector<std::string> validate() const;
};

}  // namespace conddp
