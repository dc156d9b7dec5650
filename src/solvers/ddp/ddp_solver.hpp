#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/common/options.hpp"
#include "solvers/common/solve_record.hpp"
#include "solvers/constraints/newton_polish.hpp"
#include "solvers/constraints/outer_strategy.hpp"
#include "solvers/globalization/globalization.hpp"
#include "solvers/iterate/ddp_recipe.hpp"
#include "solvers/iterate/iterate.hpp"
#include "solvers/iterate/stationarity_check.hpp"

namespace conddp {

/// What is known of the iterate at which a solve ends because its iterations are used up.
/// - linearized: everything, by derivatives and a sweep at the iterate;
/// - evaluated: cost, gap and violation. Gains are those of the sweep that led to it, and the
///   stationarity is that before the last step. Where constraints enter what is minimised, the
///   iterate is linearised all the same, for their multipliers, but not swept.
enum class LastIterate { linearized, evaluated };

/// The loop of all DDP solvers: linearise, test convergence, find a direction and a step, record.
/// Around minimisations stands an outer strategy, and Newton's method ends the solve where the
/// recipe has it. Everything is allocated by the constructor, except workspaces of exact Hessians,
/// which the first of them allocates, or reserve_exact_hessians().
class DdpSolver {
 public:
  /// `memory` is shared with solvers that never solve at the same time; null: one of its own.
  DdpSolver(const ShootingProblem& problem, const DdpRecipe& recipe, const SolverOptions& options,
            std::shared_ptr<EvaluationMemory> memory = nullptr);

  /// For a solver that is used again: no later solve has to allocate, whenever it turns to exact
  /// Hessians.
  void reserve_exact_hessians() { iterate_.hessian.reserve(); }

  /// Goes on in what memory of another solver fits, which gets this one's in return: caches hold
  /// the memory of a solver that has just been used. Between solves; answers lose their gains.
  void exchange_memory(DdpSolver& other);

  /// The answer stays until the next solve begins. From the second solve on nothing else is
  /// allocated, but for messages of solves that fail.
  const SolveResult& solve(const Trajectory& guess, LastIterate last = LastIterate::linearized);
  /// Moves the gains of the answer out; `to` has their shape.
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
  void write_residuals();
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
  bool constrained_;  ///< constraints enter the function that is minimised
  ControlBounds bounds_;
  Evaluator evaluator_;
  SolveRecord record_;
  Iterate iterate_;
  std::unique_ptr<OuterStrategy> outer_;
  Globalization globalization_;
  StationarityCheck check_;
  std::optional<NewtonPolish> polish_;
  Evaluation answer_;       ///< of an iterate that is evaluated alone
  Trajectory step_start_;   ///< what the step under way began with
  bool stepping_ = false;   ///< a step is under way that began at step_start_
  bool abandoned_ = false;  ///< an iteration was given up half-way
  bool by_newton_ = false;  ///< the solve ended with the polish
  bool last_step_ = false;  ///< the solve may end without derivatives after its last step
  bool evaluated_ = false;  ///< and did so
};

}  // namespace conddp
