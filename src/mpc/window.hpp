#pragma once

#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "mpc/plan.hpp"
#include "mpc/plan_trial.hpp"
#include "mpc/swing_starts.hpp"
#include "solvers/strategies/reusable_solver.hpp"

namespace conddp {

/// What the horizon of a tick consists of.
struct WindowCut {
  double begin = 0, end = 0;  ///< s
  std::vector<TimedKnot> knots;
  /// Whether the time line's terminal costs and constraints count: where the window reaches its
  /// end, and, where the line goes on beyond that, only if it has some.
  bool has_terminal = false;
};

/// Problems of windows: how they are made from a time line.
struct WindowContext {
  const TimeLine& line;
  double horizon;  ///< s
  /// The last node of windows that end before the time line does; null: that of the time line.
  const Phase* open_end;
  std::string_view solver;
  const SolverOptions& options;
  double cost_scale;  ///< what all costs are multiplied by (conddp::cost_scale)
  /// That their solvers share: one of them solves at a time.
  std::shared_ptr<EvaluationMemory> memory;
  const SwingStarts* swings = nullptr;  ///< null: swings begin at their footholds
};

/// Cuts [begin, begin + horizon); without hold at most until the end of the time line.
void cut_window(const WindowContext& context, double begin, WindowCut& cut);

/// The problem of windows of one structure: the same models knot by knot, the same constraints
/// switched off, the same end. It is built once and gets the numbers of each of these windows, so
/// that its solver keeps its memory.
///
/// The first state of a window is given, and constraints on it alone cannot be influenced: they are
/// switched off there.
class Window {
 public:
  Window(const WindowContext& context, const WindowCut& cut);
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  bool fits(const WindowContext& context, const WindowCut& cut) const;
  /// Takes the numbers of a window that fits.
  void load(const WindowContext& context, const WindowCut& cut);

  const ShootingProblem& problem() const { return problem_; }
  const std::vector<double>& times() const { return times_; }
  /// Solves in the memory of the window that solved last, as far as it fits.
  void exchange_memory(Window& last) { solver_.exchange_memory(last.solver_); }
  void set_initial_state(const double* x) {
    problem_.set_initial_state({x, static_cast<std::size_t>(problem_.nx())});
  }
  /// Starts the next solve with what a plan says at the times of the nodes: states, controls, and
  /// multipliers of knots of the same model; from its initial state.
  void guess_from(const Plan& plan, PolicyScratch& scratch);
  /// To the tolerances, without restorations of feasibility.
  const SolveResult& solve();
  /// By as many iterations as the options allow, with the gains of the last sweep.
  const SolveResult& iterate() { return solver_.iterate(guess_); }
  /// With restorations of feasibility and these options, by a solver that is not used again.
  const SolveResult& solve(std::string_view solver, const SolverOptions& options);
  /// Whether the answer of the last solve, which began with this plan, is better than to go on with
  /// the plan (PlanTrial). Allocates.
  bool is_improved_by(const SolveResult& answer, const Plan& plan, double tolerance);
  /// Keeps the answer of the last solve, which loses its gains, in a plan that is not this one.
  /// The next solve gets the memory of the gains of `spare`, if any, which caches hold: a plan that
  /// no policy follows.
  Plan& keep(const SolveResult& answer, const Plan* used, Plan* spare);

 private:
  void guess_node(int node, const Plan& plan, PolicyScratch& scratch);
  void guess_multipliers(int node, const Plan& plan);

  ShootingProblem problem_;
  std::vector<double> times_;
  std::vector<KnotNumbers> numbers_;
  std::vector<std::vector<double>> parameters_;  ///< one a node
  std::shared_ptr<DualGuess> multipliers_;
  ReusableSolver solver_;
  std::optional<SolveResult> other_;  ///< of a solve with other options
  Trajectory guess_;
  std::vector<Plan> plans_;
  std::unique_ptr<PlanTrial> trial_;  ///< from the first comparison on
};

}  // namespace conddp
