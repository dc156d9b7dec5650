#include "mpc/mpc.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/stopwatch.hpp"
#include "ocp/evaluation/evaluation_memory.hpp"
#include "ocp/problem/cost_scale.hpp"
#include "solvers/common/feasible.hpp"
#include "solvers/strategies/strategies.hpp"

namespace conddp {
namespace {

void require(bool holds, const char* message) {
  if (!holds) throw std::invalid_argument(message);
}

bool is_positive(double value) { return std::isfinite(value) && value > 0; }

void check_rates(const MpcOptions& options) {
  require(is_positive(options.horizon), "the horizon has to be positive");
  require(is_positive(options.tick), "the tick has to be positive");
  require(options.tick <= options.horizon, "a tick cannot be longer than the horizon");
  require(options.delay >= 0 && options.delay <= options.tick,
          "the delay has to lie between 0 and the tick");
  require(!options.iterations || *options.iterations > 0, "a tick needs an iteration at least");
  const SolverInfo* solver = find_solver(options.solver);
  require(!options.iterations || solver == nullptr || solver->real_time,
          "the solver has no real-time iteration: it solves windows to the tolerances");
  require(!options.feedback_rate || is_positive(*options.feedback_rate),
          "the rate of the feedback has to be positive");
  require(options.fallback_after > 0, "the fallback follows one failed tick at least");
}

bool is_multiple(double length, double step) {
  return std::abs(length - std::round(length / step) * step) < kSameTime;
}

/// Windows of discrete-time systems, and of contact-implicit steps, consist of whole knots.
void check_whole_knot(const ShootingProblem& problem, int k, const MpcOptions& options,
                      bool steps) {
  const double dt = problem.knot(k).dt;
  const double period = options.feedback_rate && !steps ? 1 / *options.feedback_rate : 0;
  for (const double length :
       {options.tick, options.delay, options.horizon, period, problem.times()[k]})
    require(is_multiple(length, dt),
            steps ? "contact-implicit steps have one length: tick, delay, horizon and the begin of "
                    "a knot have to be multiples of it"
                  : "the system gives the next state itself: tick, delay, horizon, the period of "
                    "the feedback and the begin of a knot have to be multiples of the knot's dt");
}

void check_knots(const ShootingProblem& problem, const MpcOptions& options) {
  for (int k = 0; k < problem.knots(); ++k) {
    const KnotModel& model = *problem.knot(k).model;
    require(model.system().as_collocation() == nullptr,
            "problems with collocation cannot be cut into windows");
    const bool steps = model.system().as_stepping() != nullptr;
    if ((steps || model.integrator() == Integrator::discrete) && !problem.takes_no_time(k))
      check_whole_knot(problem, k, options, steps);
  }
}

const MpcOptions& checked(const MpcOptions& options, const ShootingProblem& problem) {
  check_rates(options);
  check_knots(problem, options);
  require(problem.terminal().model->step().controls_in_state() == 0,
          "plans have no linear controls");
  if (options.retiming) {
    require(options.hold, "re-timing moves the end of a time line, which has to be held");
    require(options.retiming->early >= 0 && options.retiming->late >= 0,
            "limits of re-timing are not negative");
    require(static_cast<int>(options.retiming->contacts.size()) == problem.knots(),
            "re-timing needs the contacts of every knot");
  }
  if (options.fallback) {
    const HeldState& held = *options.fallback;
    require(static_cast<int>(held.x.size()) == problem.nx() && held.u.size() == problem.nu(0) &&
                held.K.rows() == problem.nu(0) && held.K.cols() == problem.ndx(),
            "the fallback has another shape than the problem");
  }
  return options;
}

/// A last node without costs and constraints.
Phase empty_end(const ShootingProblem& problem) {
  return {.name = "window end",
          .model = std::make_shared<KnotModel>(problem.terminal().model->step()),
          .dt = {0},
          .cost_scale = {1}};
}

/// Last node of windows that end before the time line does. If empty, this is the time line's own
/// last node, with its current numbers.
std::optional<OpenEnd> open_end(const MpcOptions& options, const ShootingProblem& problem) {
  if (!options.terminal) return OpenEnd(empty_end(problem), nullptr);
  const Phase &wanted = *options.terminal, &own = problem.terminal();
  const bool same = wanted.model == own.model && wanted.parameters == own.parameters &&
                    wanted.cost_scale == own.cost_scale;
  if (same && options.terminal_path == nullptr) return std::nullopt;
  return OpenEnd(wanted, options.terminal_path);
}

std::optional<SwingStarts> swing_starts(const MpcOptions& options, const TimeLine& line) {
  if (!options.swings) return std::nullopt;
  return SwingStarts(*options.swings, line);
}

Plan plan_of_guess(const ShootingProblem& problem, const Trajectory& guess) {
  Plan plan(problem);
  require(guess.knots() == problem.knots() && guess.nx() == problem.nx(),
          "the guess has another shape than the problem");
  plan.times = problem.times();
  plan.trajectory = guess;
  return plan;
}

bool is_finite(std::span<const double> x) {
  return std::all_of(x.begin(), x.end(), [](double value) { return std::isfinite(value); });
}

/// Options of a tick's solve. It starts from the multipliers of the former plan, so high penalties
/// do not make the problem stiff. Low penalties would release constraints: a few iterations leave
/// no time to raise them, and multipliers would oscillate from tick to tick.
SolverOptions tick_options(const MpcOptions& options) {
  constexpr double kSteeper = 1e3;
  SolverOptions own = options.solver_options;
  if (options.iterations) own.max_iterations = *options.iterations;
  auto& lagrangian = own.augmented_lagrangian;
  lagrangian.initial_penalty =
      std::min(kSteeper * lagrangian.initial_penalty, lagrangian.max_penalty);
  return own;
}

int largest_control(const ShootingProblem& problem) {
  int most = 0;
  for (int k = 0; k < problem.knots(); ++k) most = std::max(most, problem.nu(k));
  return most;
}

}  // namespace

std::string_view to_string(TickOutcome outcome) {
  switch (outcome) {
    case TickOutcome::planned:
      return "planned";
    case TickOutcome::improved:
      return "improved";
    case TickOutcome::not_finite:
      return "not_finite";
    case TickOutcome::late:
      return "late";
    case TickOutcome::infeasible:
      return "infeasible";
    case TickOutcome::diverged:
      return "diverged";
    case TickOutcome::out_of_iterations:
      return "out_of_iterations";
    case TickOutcome::no_step:
      break;
  }
  return "no_step";
}

Mpc::Mpc(std::shared_ptr<const ShootingProblem> problem, const Trajectory& guess,
         MpcOptions options)
    : options_(checked(options, *problem)),
      tick_options_(tick_options(options_)),
      line_(std::move(problem), options.hold),
      swings_(swing_starts(options_, line_)),
      open_end_(open_end(options_, line_.problem())),
      cost_scale_(cost_scale(line_.problem())),
      held_(options_.fallback),
      model_(line_, {}),
      scratch_(line_.problem()),
      guess_(plan_of_guess(line_.problem(), guess)),
      memory_(std::make_shared<EvaluationMemory>(tick_options_.threads)),
      in_force_{.plan = &guess_},
      before_(in_force_),
      state_(line_.problem().initial_state()),
      predicted_(state_),
      control_(largest_control(line_.problem())) {
  planned_control(guess_, 0, in_force_.first);
  before_.first = in_force_.first;
}

Mpc::~Mpc() = default;

WindowContext Mpc::context() const {
  return {.line = line_,
          .horizon = options_.horizon,
          .open_end = open_end_ ? &open_end_->phase() : nullptr,
          .solver = options_.solver,
          .options = tick_options_,
          .cost_scale = cost_scale_,
          .memory = memory_,
          .swings = swings_ ? &*swings_ : nullptr};
}

/// Starts at the window used last: usually it fits, or the one built after it does.
Window& Mpc::window_of(const WindowCut& cut) {
  const WindowContext own = context();
  const std::size_t count = windows_.size();
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = (used_ + i) % count;
    if (!windows_[at]->fits(own, cut)) continue;
    used_ = at;
    return *windows_[at];
  }
  used_ = count;
  return *windows_.emplace_back(std::make_unique<Window>(own, cut));
}

void Mpc::reserve(double until) {
  for (int tick = tick_; !is_before(until, tick * options_.tick); ++tick) {
    cut_window(context(), line_time(tick * options_.tick + options_.delay), cut_);
    if (cut_.knots.empty()) return;
    window_of(cut_);
  }
}

void Mpc::take_numbers(std::shared_ptr<const ShootingProblem> source,
                       std::shared_ptr<const StatePath> terminal_path) {
  line_.take_numbers(std::move(source));
  if (open_end_) open_end_->follow(std::move(terminal_path));
}

bool Mpc::goes_on() const {
  return line_.is_held() || is_before(line_time(plan_begin()), line_.end());
}

/// Start of the next phase after a time that adds contacts, and the added contacts.
std::optional<double> Mpc::next_touch_down(double from, std::uint32_t& contacts) const {
  const std::vector<std::uint32_t>& held = options_.retiming->contacts;
  const std::vector<double>& times = line_.problem().times();
  for (int k = line_.at(from).knot; k + 1 < line_.problem().knots(); ++k) {
    contacts = held[k + 1] & ~held[k];
    if (contacts != 0 && is_before(from, times[k + 1])) return times[k + 1];
  }
  return std::nullopt;
}

void Mpc::see_contacts(std::uint32_t closed) {
  if (!options_.retiming || tick_ == 0) return;
  const double now = line_time(time());
  std::uint32_t contacts = 0;
  const auto touch_down = next_touch_down(now - options_.tick, contacts);
  if (!touch_down) return;
  const double ahead = *touch_down - now;
  const bool all = (contacts & ~closed) == 0;
  if (all && ahead > kSameTime && !is_before(options_.retiming->early, ahead)) shift_ += ahead;
  const bool waits = !all && !is_before(now, *touch_down) &&
                     !is_before(options_.retiming->late, waited_ + options_.tick);
  if (waits) shift_ -= options_.tick;
  waited_ = waits ? waited_ + options_.tick : 0;
}

const Mpc::Policy& Mpc::policy_at(double time) const {
  return is_before(time, in_force_.begin) ? before_ : in_force_;
}

/// True if a policy without feedback between ticks still holds its first control.
bool Mpc::holds_first(const Policy& policy, double time) const {
  if (options_.feedback_rate) return false;
  return policy.held ||
         policy.plan->knot_at(line_time(time)) == policy.plan->knot_at(line_time(policy.begin));
}

void Mpc::follow(const Policy& policy, double time, const double* x, Eigen::VectorXd& u) {
  const bool gains = options_.feedback_rate || std::abs(time - policy.begin) < kSameTime;
  if (policy.held)
    control_of(*held_, *line_.problem().knot(line_.at(line_time(time)).knot).model, x, scratch_, u);
  else if (gains)
    control_of(*policy.plan, line_time(time), planned_state(*policy.plan, line_time(time)), x,
               scratch_, u);
  else
    planned_control(*policy.plan, line_time(time), u);
}

/// Inside a knot, this is the model's prediction and not the interpolated state. Gains about the
/// latter would steer a motion that follows the plan.
const double* Mpc::planned_state(const Plan& plan, double time) {
  const int k = plan.knot_at(time);
  const double begin = plan.times[k];
  if (!is_before(begin, time) || !is_before(time, plan.times[k + 1])) {
    plan.state_at(time, false, scratch_.tangent.data(), scratch_.x.data());
  } else {
    std::copy_n(plan.trajectory.x(k).data(), scratch_.x.size(), scratch_.x.begin());
    model_.step(begin, time - begin, plan.trajectory.u(k).data(), scratch_.x.data());
  }
  return scratch_.x.data();
}

const Eigen::VectorXd& Mpc::control(double time, const double* x) {
  const Policy& policy = policy_at(time);
  if (holds_first(policy, time))
    control_ = policy.first;
  else
    follow(policy, time, x, control_);
  return control_;
}

double Mpc::next_change(double time) const {
  const Policy& policy = policy_at(time);
  double next =
      is_before(time, in_force_.begin) ? in_force_.begin : in_force_.begin + options_.tick;
  if (!is_before(time, next)) next = time + options_.tick;
  if (options_.feedback_rate) {
    const double period = 1 / *options_.feedback_rate;
    const double count = std::floor((time - policy.begin + kSameTime) / period) + 1;
    next = std::min(next, policy.begin + count * period);
  }
  if (policy.held) return next;
  const std::vector<double>& knots = policy.plan->times;
  const auto later = std::upper_bound(knots.begin(), knots.end(), line_time(time) + kSameTime);
  return later == knots.end() ? next : std::min(next, *later - shift_);
}

void Mpc::predict(double from, double to, std::vector<double>& x) {
  struct Law {
    Mpc& mpc;
    const double* control(double time, const double* state) {
      return mpc.control(time - mpc.shift_, state).data();
    }
    double next_change(double time) const {
      return mpc.line_time(mpc.next_change(time - mpc.shift_));
    }
  } law{*this};
  HeldControl held;
  simulate(model_, line_time(from), line_time(to), law, held, x.data(),
           [](double, double, const double*) { return true; });
}

void Mpc::solve_from(const std::vector<double>& x) {
  window_->set_initial_state(x.data());
  window_->guess_from(*in_force_.plan, scratch_);
  const bool first = in_force_.plan == &guess_;
  if (options_.iterations && !first && options_.simulate_guess)
    window_->simulate_guess(*in_force_.plan, options_.simulate_guess);
  if (options_.iterations && !first)
    answer_ = &window_->iterate();
  else if (!first)
    answer_ = &window_->solve();
  // Solves with restoration of feasibility: a first plan has nothing to fall back on, and a solver
  // without restoration only suspects that the problem is infeasible.
  if (first || (!options_.iterations && got_stuck(*answer_, options_.solver_options)))
    answer_ = &window_->solve(options_.solver, options_.solver_options);
}

void Mpc::prepare() {
  record_ = {.tick = tick_, .time = time(), .shift = shift_};
  answer_ = nullptr;
  const Stopwatch watch(record_.preparation);
  const double began = now();
  cut_window(context(), line_time(plan_begin()), cut_);
  if (cut_.knots.empty()) throw std::logic_error("the time line has ended");
  if (open_end_) open_end_->move_to(cut_.end);
  Window* const former = windows_.empty() ? nullptr : windows_[used_].get();
  window_ = &window_of(cut_);
  if (former != nullptr && former != window_) window_->exchange_memory(*former);
  predicted_ = state_;
  predict(in_force_.begin, plan_begin(), predicted_);
  if (swings_) swings_->see(line_, line_time(plan_begin()), predicted_.data());
  window_->load(context(), cut_);
  if (solves_before_measurement()) solve_from(predicted_);
  prepared_in_ = now() - began;
}

/// Sets the state at the start of the plan from the measurement. If the measurement is not finite,
/// keeps the predicted state and returns false.
bool Mpc::measure(std::span<const double> x) {
  state_ = predicted_;
  if (!is_finite(x)) return false;
  state_.assign(x.begin(), x.end());
  predict(time(), plan_begin(), state_);
  return true;
}

const Eigen::VectorXd& Mpc::feedback(std::span<const double> x) {
  require(static_cast<int>(x.size()) == line_.problem().nx(),
          "the measured state has the wrong number of entries");
  require(window_ != nullptr, "prepare() comes first");
  const Stopwatch watch(record_.feedback);
  asked_at_ = now();
  const bool measured = measure(x);
  if (measured && !solves_before_measurement()) solve_from(state_);
  record_.outcome = measured ? outcome() : TickOutcome::not_finite;
  if (improves(record_.outcome)) record_.outcome = TickOutcome::improved;
  decide();
  ++tick_;
  window_ = nullptr;
  return in_force_.first;
}

bool Mpc::is_late() const {
  if (options_.is_late && options_.is_late(tick_)) return true;
  return in_force_.plan != &guess_ && prepared_in_ + now() - asked_at_ > options_.tick;
}

TickOutcome Mpc::outcome() const {
  if (is_late()) return TickOutcome::late;
  const bool feasible = is_feasible(answer_->residuals, options_.solver_options.tolerances);
  switch (answer_->status) {
    case SolveStatus::converged:
    case SolveStatus::cost_settled:
      return TickOutcome::planned;
    case SolveStatus::max_iterations:
      return options_.iterations ? TickOutcome::planned : TickOutcome::out_of_iterations;
    case SolveStatus::time_limit:
    case SolveStatus::interrupted:
      return TickOutcome::late;
    case SolveStatus::infeasible:
      return TickOutcome::infeasible;
    case SolveStatus::diverged:
      return TickOutcome::diverged;
    case SolveStatus::line_search_failed:
    case SolveStatus::regularization_limit:
      break;
  }
  return feasible ? TickOutcome::planned : TickOutcome::no_step;
}

/// True if an answer that misses its tolerances still beats the former plan. An active fallback
/// yields only to an answer within tolerances.
bool Mpc::improves(TickOutcome outcome) const {
  const bool misses = outcome == TickOutcome::infeasible ||
                      outcome == TickOutcome::out_of_iterations || outcome == TickOutcome::no_step;
  return misses && !in_force_.held &&
         window_->is_improved_by(*answer_, *in_force_.plan,
                                 options_.solver_options.tolerances.constraint);
}

/// Puts the answer in force, or keeps the former policy.
void Mpc::decide() {
  before_ = in_force_;
  in_force_.begin = plan_begin();
  const bool planned = record_.outcome == TickOutcome::planned;
  if (planned || record_.outcome == TickOutcome::improved) {
    Plan& kept = window_->keep(*answer_, before_.plan, older_plan_);
    older_plan_ = last_plan_;
    last_plan_ = &kept;
    // Multipliers of infeasible constraints grow without bound: the next solve starts from zero.
    if (!planned) kept.multipliers.setZero();
    in_force_.plan = &kept;
  }
  if (planned) {
    in_force_.held = false;
    failures_ = 0;
  } else if (++failures_ >= options_.fallback_after && held_) {
    if (!in_force_.held && held_->settle) held_->settle(state_.data(), held_->x);
    in_force_.held = true;
  }
  if (answer_ != nullptr) {
    record_.solved = true;
    record_.status = answer_->status;
    record_.iterations = answer_->iterations;
    record_.cost = answer_->cost / cost_scale_;
    record_.stationarity = answer_->residuals.stationarity / cost_scale_;
    record_.gap = answer_->residuals.gap;
    record_.violation = answer_->residuals.constraint;
  }
  predicted_ = state_;  // the first control follows the impulses at its time
  model_.pass_instants(line_time(in_force_.begin), predicted_.data());
  follow(in_force_, in_force_.begin, predicted_.data(), in_force_.first);
  record_.plan_age = line_time(in_force_.begin) - in_force_.plan->times.front();
  record_.fallback = in_force_.held;
}

}  // namespace conddp
