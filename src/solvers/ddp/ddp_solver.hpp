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

/// The loop of all DDP solvers: linearise, test convergence, find a direction and a step, record.
/// Around minimisations stands an outer strategy, and Newton's method ends the solve where the
/// recipe has it. Everything is allocated by the constructor, except workspaces of exact Hessians,
/// which the first of them allocates, or reserve_exact_hessians().
class DdpSolver {
 public:
  DdpSolver(const ShootingProblem& problem, const DdpRecipe& recipe, const SolverOptions& options);

  /// For a solver that is used again: no later solve has to allocate, whenever it turns to exact
  /// Hessians.
  void reserve_exact_hessians() { iterate_.hessian.reserve(); }

  /// The answer stays until the next solve begins. From the second solve on nothing else is
  /// allocated, but for messages of solves that fail.
  const SolveResult& solve(const Trajectory& guess);
  /// Moves the answer out of the solver.
  SolveResult take() { return std::move(record_.result); }

 private:
  bool start(const Trajectory& guess);
  bool end_at_guess(const Trajectory& guess, int bad_knot);
  void iterate();
  bool run_iteration();
  void fit_outer();
  bool ends();
  bool goes_on();
  bool linearize();
  void measure();
  bool converged() const;
  bool confirm();
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
  Trajectory step_start_;   ///< what the step under way began with
  bool stepping_ = false;   ///< a step is under way that began at step_start_
  bool abandoned_ = false;  ///< an iteration was given up half-way
  bool by_newton_ = false;  ///< the solve ended with the polish
};

}  // namespace conddp
