#pragma once

#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "mpc/plan.hpp"
#include "mpc/swing_starts.hpp"
#include "solvers/strategies/reusable_solver.hpp"

namespace conddp {

/// Horizon of a tick.
struct WindowCut {
  double begin = 0, end = 0;  ///< s
  std::vector<TimedKnot> knots;
  /// True if the time line's terminal costs and constraints apply: the window reaches the line's
  /// end and, if the line is held, there are any.
  bool has_terminal = false;
};

/// Data for building the problems of windows from a time line.
struct WindowContext {
  const TimeLine& line;
  double horizon;  ///< s
  /// Last node of windows that end before the time line does; null for the time line's own.
  const Phase* open_end;
  std::string_view solver;
  const SolverOptions& options;
  double cost_scale;  ///< factor of all costs (conddp::cost_scale)
  /// Shared by the solvers: only one of them solves at a time.
  std::shared_ptr<EvaluationMemory> memory;
  const SwingStarts* swings = nullptr;  ///< null: swings begin at their footholds
};

/// Cuts [begin, begin + horizon). Without hold, a window ends at the end of the time line at the
/// latest.
void cut_window(const WindowContext& context, double begin, WindowCut& cut);

/// Problem of windows of one structure: the same models knot by knot, the same inactive
/// constraints, the same end. It is built once and loads the numbers of each window, so its solver
/// keeps its memory.
///
/// The first state of a window is given. Constraints on it alone cannot be influenced and are
/// switched off.
class Window {
 public:
  Window(const WindowContext& context, const WindowCut& cut);
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  bool fits(const WindowContext& context, const WindowCut& cut) const;
  /// Loads the numbers of a window that fits.
  void load(const WindowContext& context, const WindowCut& cut);

  const ShootingProblem& problem() const { return problem_; }
  const std::vector<double>& times() const { return times_; }
  /// Takes over the memory of the window that solved last, as far as it fits.
  void exchange_memory(Window& last) { solver_.exchange_memory(last.solver_); }
  void set_initial_state(const double* x) {
    problem_.set_initial_state({x, static_cast<std::size_t>(problem_.nx())});
  }
  /// Sets the next guess from a plan at the node times: states, controls, and multipliers of knots
  /// of the same model. The first state is the window's initial state.
  void guess_from(const Plan& plan, PolicyScratch& scratch);
  /// Changes the guess by a function of the problem, the plan's gains, and the guess.
  template <class Simulate>
  void simulate_guess(const Plan& plan, const Simulate& simulate) {
    simulate(problem_, gains_of(plan), guess_);
  }
  /// Solves to the tolerances, without restorations of feasibility.
  const SolveResult& solve();
  /// Runs the number of iterations in the options; the gains are those of the last sweep.
  const SolveResult& iterate() { return solver_.iterate(guess_); }
  /// Solves with restorations of feasibility and these options, using a solver once.
  const SolveResult& solve(std::string_view solver, const SolverOptions& options);
  /// True if the answer of the last solve, which started from this plan, beats following the plan
  /// (PlanTrial). Allocates.
  bool is_improved_by(const SolveResult& answer, const Plan& plan, double tolerance);
  /// Keeps the answer of the last solve, whose gains are moved out, in a plan other than `used`.
  /// The next solve reuses the gain memory of `spare`, if any, which is in cache: a plan that no
  /// policy follows.
  Plan& keep(const SolveResult& answer, const Plan* used, Plan* spare);

 private:
  void guess_node(int node, const Plan& plan, PolicyScratch& scratch);
  void guess_multipliers(int node, const Plan& plan);
  Feedback gains_of(const Plan& plan) const;

  ShootingProblem problem_;
  std::vector<double> times_;
  std::vector<KnotNumbers> numbers_;
  std::vector<std::vector<double>> parameters_;  ///< by node
  std::shared_ptr<DualGuess> multipliers_;
  ReusableSolver solver_;
  std::optional<SolveResult> other_;  ///< answer of a solve with other options
  Trajectory guess_;
  std::vector<Plan> plans_;
  std::unique_ptr<PlanTrial> trial_;  ///< built by the first comparison
};

}  // namespace conddp
