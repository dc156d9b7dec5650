#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/common/options.hpp"
#include "solvers/common/solve_record.hpp"
#include "solvers/constraints/outer_strategy.hpp"
#include "solvers/constraints/projected_newton.hpp"
#include "solvers/globalization/globalization.hpp"
#include "solvers/iterate/ddp_recipe.hpp"
#include "solvers/iterate/iterate.hpp"
#include "solvers/iterate/stationarity_check.hpp"

namespace conddp {

/// Extent of what a solve computes at the last iterate when it reaches its iteration limit.
/// - linearized: everything, from derivatives and a sweep at the iterate;
/// - evaluated: cost, gap, violation and multipliers. The gains come from the sweep that led to the
///   iterate, and the stationarity is the one before the last step. Sweeps are limited (a real-time
///   iteration).
enum class LastIterate { linearized, evaluated };

/// The loop of all DDP solvers: linearize, test convergence, find a direction and a step, record.
/// An outer strategy surrounds the minimizations, and Newton's method ends the solve if the recipe
/// uses it. The constructor allocates everything except the workspaces of exact Hessians. Their
/// first use or reserve_exact_hessians() allocates those.
class DdpSolver {
 public:
  /// `memory` may be shared with solvers that never solve at the same time; null creates its own.
  DdpSolver(const ShootingProblem& problem, const DdpRecipe& recipe, const SolverOptions& options,
            std::shared_ptr<EvaluationMemory> memory = nullptr);

  /// Allocates the workspaces of exact Hessians in advance, so that later solves of a reused solver
  /// never have to.
  void reserve_exact_hessians() { iterate_.hessian.reserve(); }

  /// Exchanges matrices of equal shape with another solver: memory of a solver that has just been
  /// used is still in the caches. To be called between solves; both answers lose their gains.
  void exchange_memory(DdpSolver& other);

  /// The answer stays valid until the next solve begins. From the second solve on, only the
  /// messages of failed solves allocate memory.
  const SolveResult& solve(const Trajectory& guess, LastIterate last = LastIterate::linearized);
  /// Swaps the gains of the answer into `to`, which has their shape.
  void take_feedback(Feedback& to) { std::swap(record_.result.feedback, to); }
  /// Moves the answer out of the solver.
  SolveResult take() { return std::move(record_.result); }

 private:
  bool start(const Trajectory& guess);
  bool end_at_guess(const Trajectory& guess, int bad_knot);
  void iterate();
  bool run_iteration();
  bool ends_by_last_step();
  void end_evaluated();
  void fit_outer();
  bool ends();
  bool goes_on();
  bool linearize();
  void measure();
  bool converged() const;
  bool is_confirmable() const;
  bool confirm();
  double share_left();
  bool cost_settled();
  bool polish();
  bool next_minimization();
  bool step();
  void finish();
  void replace_costates();
  void end_log();
  void confirm_status();
  void name_contradiction();
  void find_gains();

  const ShootingProblem& problem_;
  DdpRecipe recipe_;
  SolverOptions options_;
  bool constrained_;  ///< constraints enter the minimized function
  ControlBounds bounds_;
  Evaluator evaluator_;
  SolveRecord record_;
  Iterate iterate_;
  std::unique_ptr<OuterStrategy> outer_;
  Globalization globalization_;
  StationarityCheck check_;
  std::optional<NewtonPolish> polish_;
  Evaluation answer_;       ///< of an iterate that is evaluated but not linearized
  Trajectory step_start_;   ///< the iterate before the step in progress
  bool stepping_ = false;   ///< a step that began at step_start_ is in progress
  bool abandoned_ = false;  ///< an iteration was interrupted
  bool by_newton_ = false;  ///< the Newton polish ended the solve
  bool last_step_ = false;  ///< the solve may end without derivatives after its last step
  bool evaluated_ = false;  ///< the solve ended in this way
};

}  // namespace conddp
