#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mpc/open_end.hpp"
#include "mpc/plant_motion.hpp"
#include "mpc/window.hpp"

namespace conddp {

/// Outcome of a tick. Every value except `planned` is a failure; every failure except `improved`
/// leaves the former plan in force.
enum class TickOutcome {
  planned,            ///< a new plan is in force
  improved,           ///< a new plan is in force; it beats the former one but misses its tolerances
  not_finite,         ///< the measured state is not finite
  late,               ///< the answer came too late
  infeasible,         ///< the solver found no way to satisfy the constraints
  diverged,           ///< a state, cost or derivative was not finite
  out_of_iterations,  ///< the iterations were used up before the tolerances were met
  no_step,            ///< no step lowers the merit, and the trajectory is not feasible
};
/// Name in outputs: "planned", "not_finite", ...
std::string_view to_string(TickOutcome outcome);

/// Phases begin with their contacts instead of at their planned times. The time line must be held.
struct Retiming {
  double early = 0;  ///< s, maximum advance of a phase
  double late = 0;   ///< s, maximum extension of a phase
  /// Contacts that each knot of the problem holds, one bit each.
  std::vector<std::uint32_t> contacts;
};

struct MpcOptions {
  double horizon = 1;  ///< s, length of windows
  double tick = 0.01;  ///< s, between plans
  /// Solver iterations in each tick except the first, which is solved to the tolerances. If unset,
  /// every tick is.
  std::optional<int> iterations = 1;
  bool hold = true;  ///< the last knot repeats after the end of the time line
  double delay = 0;  ///< s, from a measurement to the first control of its plan; at most a tick
  /// Rate at which gains act, Hz; they also act where knots of the plan begin. If unset, gains act
  /// only at the first control of each plan.
  std::optional<double> feedback_rate;
  /// Last node of windows that end before the time line does. If unset, it has no costs and
  /// constraints. If it is the problem's own terminal node, it takes the numbers of take_numbers(),
  /// too.
  std::optional<Phase> terminal;
  /// Path of those references of `terminal` that are states, by time on the time line at the end of
  /// a window. If null, they stay.
  std::shared_ptr<const StatePath> terminal_path;
  /// Controller after `fallback_after` failed ticks in a row. If unset, the former plan stays in
  /// force.
  std::optional<HeldState> fallback;
  int fallback_after = 3;
  /// Any solver. `ipopt` has no real-time iteration: it solves to the tolerances and allocates, a
  /// slow reference.
  std::string solver = "box_fddp";
  SolverOptions solver_options;
  /// Swings that begin at the actual positions of the feet. If unset, all begin at their footholds.
  std::optional<FootSwings> swings;
  /// If unset, phases begin at their planned times.
  std::optional<Retiming> retiming;
  /// Makes the guess of a real-time iteration, the shifted plan from another first state, a motion
  /// of the problem under the plan's gains. For contact-implicit steps, whose forces would not be
  /// those of the new state. Null: guesses stay.
  std::function<void(const ShootingProblem&, const Feedback&, Trajectory&)> simulate_guess;
  /// True if the answer of a tick is late; null for never.
  std::function<bool(int tick)> is_late;
  /// Clock, s. An answer is late if its preparation and feedback together take longer than a tick.
  /// The first plan is exempt: it is made before the loop begins. If null, solves take no time.
  std::function<double()> clock;
};

/// Record of a tick.
struct TickRecord {
  int tick = 0;
  double time = 0;  ///< s, time of the measurement
  TickOutcome outcome = TickOutcome::planned;
  SolveStatus status = SolveStatus::diverged;  ///< status of the tick's solve
  bool solved = false;                         ///< true if a solve took place
  int iterations = 0;
  double cost = 0, stationarity = 0, gap = 0, violation = 0;  ///< of its answer
  double plan_age = 0;                                        ///< s, age of the plan in force
  double shift = 0;                      ///< s, shift of the time line by re-timing
  bool fallback = false;                 ///< true if the fallback is in force
  double preparation = 0, feedback = 0;  ///< wall-clock time, s
};

/// Model predictive control of a problem. Tick j measures at j·tick; its plan begins at j·tick +
/// delay. After `reserve`, ticks whose solves succeed allocate nothing. Failed solves allocate for
/// messages, restorations of feasibility and comparisons with the former plan.
class Mpc {
 public:
  /// `guess` has the problem's shape. Throws std::invalid_argument if options are out of range or
  /// do not allow windows of the problem to be solved; the message gives the reason.
  Mpc(std::shared_ptr<const ShootingProblem> problem, const Trajectory& guess, MpcOptions options);
  ~Mpc();
  Mpc(const Mpc&) = delete;
  Mpc& operator=(const Mpc&) = delete;

  /// Builds the windows of all ticks up to a time (s) in advance.
  void reserve(double until);
  /// True if the time line continues after the start of the next plan.
  bool goes_on() const;
  /// From the next tick on, takes references, weights and bounds from a problem of the same
  /// structure (TimeLine::take_numbers). `terminal` then moves along `terminal_path`; null keeps
  /// the former path. The plan in force stays.
  void take_numbers(std::shared_ptr<const ShootingProblem> source,
                    std::shared_ptr<const StatePath> terminal_path = nullptr);
  /// Receives the contacts that are closed before the next tick, one bit each. With `retiming`, the
  /// time line's next touch-down happens at once if all of its contacts are closed, and waits if it
  /// is due and one of them is open.
  void see_contacts(std::uint32_t closed);
  /// Does all work that precedes the measurement.
  void prepare();
  /// Control at the start of the plan, from the state measured at time() (nx numbers). Valid until
  /// the next call of a method.
  const Eigen::VectorXd& feedback(std::span<const double> x);
  /// Control in force at a state and a time (s), at the earliest a tick before the start of the
  /// last plan. Valid until the next call of a method.
  const Eigen::VectorXd& control(double time, const double* x);
  /// Next time (s) at which the control in force changes other than by its gains, or the gains act
  /// again.
  double next_change(double time) const;

  /// Time of the next measurement, s.
  double time() const { return tick_ * options_.tick; }
  const TickRecord& last_tick() const { return record_; }
  /// Plan in force; null under the fallback.
  const Plan* plan() const { return in_force_.held ? nullptr : in_force_.plan; }
  const MpcOptions& options() const { return options_; }
  const TimeLine& time_line() const { return line_; }
  /// Time on the time line at a time of the loop, s.
  double line_time(double time) const { return time + shift_; }

 private:
  /// Control policy from a time on.
  struct Policy {
    const Plan* plan = nullptr;
    double begin = 0;
    bool held = false;           ///< the fallback is in force, not the plan
    Eigen::VectorXd first = {};  ///< control at `begin`
  };

  WindowContext context() const;
  double plan_begin() const { return time() + options_.delay; }
  std::optional<double> next_touch_down(double from, std::uint32_t& contacts) const;
  Window& window_of(const WindowCut& cut);
  const Policy& policy_at(double time) const;
  bool holds_first(const Policy& policy, double time) const;
  void follow(const Policy& policy, double time, const double* x, Eigen::VectorXd& u);
  const double* planned_state(const Plan& plan, double time);
  void predict(double from, double to, std::vector<double>& x);
  void solve_from(const std::vector<double>& x);
  bool measure(std::span<const double> x);
  double now() const { return options_.clock ? options_.clock() : 0; }
  bool is_late() const;
  /// True for real-time iterations, but for contact-implicit steps: their gains say little about
  /// contacts that the prediction missed.
  bool solves_before_measurement() const { return options_.iterations && !options_.simulate_guess; }
  TickOutcome outcome() const;
  bool improves(TickOutcome outcome) const;
  void decide();

  MpcOptions options_;
  SolverOptions tick_options_;
  TimeLine line_;
  std::optional<SwingStarts> swings_;
  std::optional<OpenEnd> open_end_;  ///< if empty, the time line's own
  double cost_scale_;                ///< scales costs of windows to their usual size
  std::optional<HeldState> held_;    ///< fallback at the state that it currently holds
  Simulation model_;
  PolicyScratch scratch_;
  Plan guess_;
  std::shared_ptr<EvaluationMemory> memory_;  ///< shared by the solvers of all windows
  std::vector<std::unique_ptr<Window>> windows_;
  std::size_t used_ = 0;  ///< index of the window that window_of() returned last
  WindowCut cut_;
  Window* window_ = nullptr;             ///< window of the current tick
  const SolveResult* answer_ = nullptr;  ///< answer of its solve
  Policy in_force_, before_;
  Plan* last_plan_ = nullptr;   ///< last plan that came into force
  Plan* older_plan_ = nullptr;  ///< plan before it; no policy follows it by the next tick
  int tick_ = 0;
  int failures_ = 0;               ///< failed ticks in a row
  double prepared_in_ = 0;         ///< by the clock, s
  double asked_at_ = 0;            ///< time of the call for a control, by the clock, s
  double shift_ = 0;               ///< shift of the time line, s
  double waited_ = 0;              ///< s, wait for the next touch-down
  std::vector<double> state_;      ///< state at the start of the last plan, as far as known
  std::vector<double> predicted_;  ///< state at the start of the next plan
  Eigen::VectorXd control_;
  TickRecord record_;
};

}  // namespace conddp
