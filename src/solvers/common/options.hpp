#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "nlp/ipopt_options.hpp"
#include "nlp/pair_relaxation.hpp"
#include "solvers/common/dual_guess.hpp"
#include "solvers/common/iteration_record.hpp"

namespace conddp {

class ShootingProblem;

/// The problems on the way of a homotopy by their share of it, in [0, 1]: all of one shape, and at
/// 1 the problem that is to be solved. Null where there is none. May be called by several threads.
using ProblemPath = std::function<std::shared_ptr<const ShootingProblem>(double share)>;

/// What regularisation adds, with weight μ:
/// `proximal`: ½ μ (‖δx‖² + ‖δu‖²) to the model's cost at every node, a term of Levenberg and
/// Marquardt that keeps the whole trajectory near the iterate; the value knows of it. To the gains
/// of a stage alone: `state`: μ I to V_xx of the next node, seen through the dynamics; `control`:
/// μ I to Q_uu. `state` need not turn a step into a descent, however large μ, where controls stand
/// at bounds.
enum class RegularizationKind { proximal, state, control };

/// Second derivatives that the sweep uses. `automatic` leaves the choice to the solver: exact for
/// ddp, Gauss-Newton for ilqr and ilqr_clip, and for the others Gauss-Newton with
/// L-BFGS corrections until exact ones pay (docs/solvers.md).
enum class HessianChoice { automatic, gauss_newton, exact };

/// What is done where complementary pairs relaxed in one way find no answer: the other ways are
/// tried one after the other, or none is.
enum class RelaxationFallback { automatic, none };

/// Everything that can be set about a DDP solve. The defaults serve the whole catalogue.
/// solvers/common/option_table.hpp lists the same options by name, with ranges and a sentence each.
struct SolverOptions {
  int max_iterations = 1000;
  double max_time_s = std::numeric_limits<double>::infinity();
  int threads = 1;
  int segments = 1;
  HessianChoice hessian = HessianChoice::automatic;

  struct Tolerances {
    double stationarity = 1e-6;
    double gap = 1e-9;
    double constraint = 1e-6;
    double complementarity = 1e-6;
    double cost_decrease = 0;
  } tolerances;

  struct Regularization {
    RegularizationKind kind = RegularizationKind::proximal;
    double initial = 0;
    double min = 1e-6;
    double max = 1e10;
    double factor = 2;
    double decrease_step = 0.5;
    double increase_step = 0.2;
  } regularization;

  struct LineSearch {
    double min_step = 1e-4;
    double armijo = 1e-4;
    double merit_margin = 1.5;
  } line_search;

  /// Of solvers that minimise an augmented Lagrangian.
  struct AugmentedLagrangian {
    double initial_penalty = 0.1;
    double penalty_factor = 10;
    double max_penalty = 1e8;
    double sufficient_decrease = 0.25;
  } augmented_lagrangian;

  struct BoxQp {
    int max_iterations = 100;
    double armijo = 0.1;
    int horizon_sweeps = 20;
  } box_qp;

  /// Of complementary pairs, of the solver `ipopt`.
  struct Complementarity {
    PairRelaxation relaxation = PairRelaxation::elementwise;
    RelaxationFallback fallback = RelaxationFallback::automatic;
    double initial = 0.01;
    double factor = 0.1;
    double final = 1e-12;
  } complementarity;

  /// Further solves from random perturbations of the guess; the best answer counts.
  struct Restarts {
    int count = 0;
    int seed = 0;
    double spread = 0.1;
  } restarts;

  /// Work of iterations (look_further.cpp) up to which solve_best looks for a better answer.
  int look_further = 5000000;

  /// Ipopt's own, by its names, of the solver `ipopt`.
  IpoptOptions ipopt;

  /// Multipliers to start from, beside the guess, of solvers that have multipliers of constraints.
  std::shared_ptr<const DualGuess> multipliers;

  /// A homotopy by which to come to the answer; none: the problem is solved at once.
  ProblemPath homotopy;

  /// Called with every row of the log as soon as it is known; the row lives during the call only.
  /// Of restarts with those of the first start.
  std::function<void(const IterationRecord&)> on_iteration;
  /// Asked once an iteration and regularisation; true ends the solve with status `interrupted`. Of
  /// restarts asked by several threads, but never by two at once or during a call of the former.
  std::function<bool()> interrupted;

  /// One message for each option whose value is out of range, naming the option; empty if all are
  /// usable. Values are never replaced.
  std::vector<std::string> validate() const;
};

}  // namespace conddp
