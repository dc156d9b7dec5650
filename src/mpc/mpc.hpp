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
#include "mpc/simulation.hpp"
#include "mpc/window.hpp"

namespace conddp {

/// What became of a tick. Every value but `planned` is a failure; all of these but `improved` leave
/// the former plan in force.
enum class TickOutcome {
  planned,            ///< a new plan is in force
  improved,           ///< so is one that misses its tolerances: it is better than the former one
  not_finite,         ///< the measured state has a number that is not finite
  late,               ///< the answer came too late
  infeasible,         ///< the solver found no way to satisfy the constraints
  diverged,           ///< a state, cost or derivative was not finite
  out_of_iterations,  ///< the tolerances were not met by the allowed iterations
  no_step,            ///< no step lowers the merit, and the trajectory is not feasible
};
/// The name in outputs: "planned", "not_finite", ...
std::string_view to_string(TickOutcome outcome);

/// Phases that begin when their contacts do, and not at their time. The time line has to be held.
struct Retiming {
  double early = 0;  ///< s: how much earlier than planned a phase may begin
  double late = 0;   ///< s: how much longer than planned one may last
  /// Of each knot of the problem the contacts that its phase holds, one bit each.
  std::vector<std::uint32_t> contacts;
};

struct MpcOptions {
  double horizon = 1;  ///< s, of windows
  double tick = 0.01;  ///< s, between two plans
  /// Of the solver, each tick but the first, which is solved to the tolerances; none: to the
  /// tolerances always.
  std::optional<int> iterations = 1;
  bool hold = true;     ///< the last knot repeats itself after the end of the time line
  double delay = 0;     ///< s, from measurement to the first control of its plan; at most a tick
  bool predict = true;  ///< plans begin at the state that is predicted for the end of the delay
  /// Gains act at this rate, Hz, and where knots of the plan begin; none: at the first control of
  /// each plan alone.
  std::optional<double> feedback_rate;
  /// The last node of windows that end before the time line does; none: nothing counts there. The
  /// problem's own gets the numbers of take_numbers(), too.
  std::optional<Phase> terminal;
  /// Where references of `terminal` that are states are when windows end, by the time line; null:
  /// they stay.
  std::shared_ptr<const StatePath> terminal_path;
  /// What controls once so many ticks in a row have failed; none: the former plan for ever.
  std::optional<HeldState> fallback;
  int fallback_after = 3;
  /// Of the DDP family, or `ipopt`, which solves to the tolerances and allocates: a slow reference.
  std::string solver = "box_fddp";
  SolverOptions solver_options;
  /// Swings that begin where the feet are; none: all at their footholds.
  std::optional<FootSwings> swings;
  /// None: phases begin at their times.
  std::optional<Retiming> retiming;
  /// Whether the answer of a tick comes too late; null: never.
  std::function<bool(int tick)> is_late;
  /// A clock, s. By it, answers come too late whose preparation and feedback take longer than a
  /// tick together, but for the first plan, which is made before the loop begins. Null: solves take
  /// no time.
  std::function<double()> clock;
};

/// What there is to say of a tick.
struct TickRecord {
  int tick = 0;
  double time = 0;  ///< s, of the measurement
  TickOutcome outcome = TickOutcome::planned;
  SolveStatus status = SolveStatus::diverged;  ///< of its solve
  bool solved = false;                         ///< whether there was one
  int iterations = 0;
  double cost = 0, stationarity = 0, gap = 0, violation = 0;  ///< of its answer
  double plan_age = 0;                                        ///< s, of the plan in force
  double shift = 0;                      ///< s, by which re-timing has moved ahead
  bool fallback = false;                 ///< the fallback is in force
  double preparation = 0, feedback = 0;  ///< wall-clock s
};

/// Model predictive control of a problem. Tick j measures at j·tick; its plan begins at
/// j·tick + delay. After `reserve`, ticks that are solved allocate nothing but for solves that
/// fail: their messages, restorations of feasibility, and comparisons with the former plan.
class Mpc {
 public:
  /// A guess of the problem's shape. Throws std::invalid_argument where options are out of range or
  /// windows of the problem cannot be solved so; the message says why.
  Mpc(std::shared_ptr<const ShootingProblem> problem, const Trajectory& guess, MpcOptions options);
  ~Mpc();
  Mpc(const Mpc&) = delete;
  Mpc& operator=(const Mpc&) = delete;

  /// Makes the windows of all ticks up to a time (s), so that none of them has to.
  void reserve(double until);
  /// Whether the time line goes on after the begin of the next plan.
  bool goes_on() const;
  /// From the next tick on references, weights and bounds are those of a problem of the same
  /// structure (TimeLine::take_numbers), and `terminal` moves on another path; null: on the one
  /// before. The plan in force stays.
  void take_numbers(std::shared_ptr<const ShootingProblem> source,
                    std::shared_ptr<const StatePath> terminal_path = nullptr);
  /// The contacts that are closed before the next tick, one bit each. With `retiming` the next
  /// touch-down of the time line comes at once where all of its contacts are closed, and waits
  /// where it is due and one of them is not.
  void see_contacts(std::uint32_t closed);
  /// All that can be done before the state is measured.
  void prepare();
  /// The control at the begin of the plan, from the state measured at time(): nx numbers. It stays
  /// until the next call of a method.
  const Eigen::VectorXd& feedback(std::span<const double> x);
  /// The control that is in force at a time (s) up to a tick before the last plan began, at a
  /// state. It stays until the next call of a method.
  const Eigen::VectorXd& control(double time, const double* x);
  /// The next time after this one at which the control in force changes but by its gains, or the
  /// gains act again, s.
  double next_change(double time) const;

  /// When the next tick measures, s.
  double time() const { return tick_ * options_.tick; }
  const TickRecord& last_tick() const { return record_; }
  /// The plan in force; none under the fallback.
  const Plan* plan() const { return in_force_.held ? nullptr : in_force_.plan; }
  const MpcOptions& options() const { return options_; }
  const TimeLine& time_line() const { return line_; }
  /// The time on the time line that belongs to a time of the loop, s.
  double line_time(double time) const { return time + shift_; }

 private:
  /// What controls from a time on.
  struct Policy {
    const Plan* plan = nullptr;
    double begin = 0;
    bool held = false;           ///< the fallback, not the plan
    Eigen::VectorXd first = {};  ///< its control at `begin`
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
  TickOutcome outcome() const;
  bool improves(TickOutcome outcome) const;
  void decide();

  MpcOptions options_;
  SolverOptions tick_options_;
  TimeLine line_;
  std::optional<SwingStarts> swings_;
  std::optional<OpenEnd> open_end_;  ///< none: that of the time line
  double cost_scale_;                ///< of windows, whose costs are of the usual size
  std::optional<HeldState> held_;    ///< the fallback, where it is now
  Simulation model_;
  PolicyScratch scratch_;
  Plan guess_;
  std::shared_ptr<EvaluationMemory> memory_;  ///< of all windows' solvers
  std::vector<std::unique_ptr<Window>> windows_;
  std::size_t used_ = 0;  ///< the one of these that window_of() gave last
  WindowCut cut_;
  Window* window_ = nullptr;             ///< of the tick under way
  const SolveResult* answer_ = nullptr;  ///< of its solve
  Policy in_force_, before_;
  Plan* last_plan_ = nullptr;   ///< that came into force
  Plan* older_plan_ = nullptr;  ///< and the one before it, which no policy has by the next tick
  int tick_ = 0;
  int failures_ = 0;               ///< in a row
  double prepared_in_ = 0;         ///< by the clock, s
  double asked_at_ = 0;            ///< for the control, by the clock, s
  double shift_ = 0;               ///< of the time line, s
  double waited_ = 0;              ///< s, for the next touch-down
  std::vector<double> state_;      ///< where the last plan began, as far as is known
  std::vector<double> predicted_;  ///< where the next one begins
  Eigen::VectorXd control_;
  TickRecord record_;
};

}  // namespace conddp
