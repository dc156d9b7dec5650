#include "problem_file/assemble/build_mpc.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include <fmt/format.h>

#include "analysis/contact/simulated_contacts.hpp"
#include "mpc/window_count.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/assemble/late_ticks.hpp"
#include "problem_file/assemble/loop_commands.hpp"
#include "problem_file/assemble/loop_regulators.hpp"
#include "problem_file/assemble/loop_swings.hpp"
#include "problem_file/assemble/simulated_plant.hpp"
#include "problem_file/assemble/tangent_numbers.hpp"
#include "problem_file/model/phase_grid.hpp"
#include "problem_file/motion/planar_motion.hpp"
#include "problem_file/motion/quasi_static.hpp"
#include "problem_file/plant/memory_need.hpp"
#include "problem_file/read/read_sections.hpp"
#include "problem_file/terms/constraint_builder.hpp"
#include "problem_file/terms/term_residual.hpp"
#include "solvers/strategies/registry.hpp"
#include "systems/system.hpp"

namespace conddp {
namespace {

/// Reports parts of a problem that cannot be divided into windows.
void check_problem(const ProblemSpec& spec, Diagnostics& out) {
  if (spec.phases.front().choice)
    out.error(spec.phases.front().name.place, "a closed loop begins at a given initial state",
              "leave out the phase that chooses it");
  if (const PhaseSpec* phase = spec.first_free_duration())
    out.error(phase->free_duration->place, "phases of a closed loop have fixed durations",
              "leave the key out");
  if (!spec.integrals.empty() && spec.mpc->plant.simulated_contacts)
    out.error(spec.integrals.front().name.place, "plants with simulated contacts have no integrals",
              "leave 'contacts: simulated' out, or the integrals");
  if (spec.stepping && !spec.mpc->plant.simulated_contacts)
    out.error(spec.mpc->place,
              "a loop with contact-implicit steps needs a plant with contacts of its own",
              "write 'plant: {contacts: simulated, dt: 0.002}'");
  if (spec.stepping && spec.mpc->fallback)
    out.error(spec.mpc->fallback->place, "loops with contact-implicit steps have no fallback",
              "leave the key out: the former plan stays in force");
  const auto collocates = [](Integrator integrator) {
    return kIntegrators[static_cast<int>(integrator)].kind == StepKind::collocation;
  };
  if (spec.integrator && collocates(spec.integrator->value))
    out.error(spec.integrator->place, "a closed loop has no collocation",
              "accepted: semi_implicit_euler, explicit_euler, rk2, rk3, rk4, discrete");
  if (spec.mesh)
    out.warning(spec.mesh->place, "'mesh' refines single solves: a closed loop keeps its grid");
  if (spec.has_linear_controls())
    out.error(spec.controls.place, "a closed loop applies constant controls, and these are linear",
              "write 'controls: constant'");
  const SolverOptions& options = spec.solver.options;
  if (std::isfinite(options.max_time_s))
    out.error(spec.solver.place,
              "the clock of a closed loop is simulated: a solve has no time limit",
              "leave out 'max_time_s'");
  if (!spec.solver.homotopy.empty() || options.restarts.count > 0)
    out.error(spec.solver.place, "the solver of a closed loop has no restarts and no homotopy");
}

bool is_multiple(double length, double step) {
  return std::abs(length - std::round(length / step) * step) < kSameTime;
}

/// Period of the feedback, s, if the file has one.
std::optional<Located<double>> feedback_period(const MpcSpec& mpc) {
  if (!mpc.feedback_rate) return std::nullopt;
  return Located<double>{1 / mpc.feedback_rate->value, mpc.feedback_rate->place};
}

/// Index of the last knot that takes time; this knot repeats.
int repeated_knot(const ShootingProblem& problem) {
  int last = problem.knots() - 1;
  while (last > 0 && problem.takes_no_time(last)) --last;
  return last;
}

/// Length of the repeated knot, s.
double repeated_step(const ShootingProblem& problem) {
  return problem.knot(repeated_knot(problem)).dt;
}

/// Reports a window with more knots than memory can hold.
void check_window(const MpcSpec& mpc, double repeated, Diagnostics& out) {
  constexpr double kMostKnots = 1e5;
  if (mpc.repeat.value != AfterTheEnd::kNone && mpc.horizon.value / repeated > kMostKnots)
    out.error(mpc.horizon.place,
              fmt::format("a horizon of {:g} s is more than {:g} knots of {:g} s, the last one of "
                          "the phases",
                          mpc.horizon.value, kMostKnots, repeated),
              "take a shorter horizon");
}

/// Reports ticks that vanish in rounding, and more steps than memory can hold.
void check_steps(const MpcSpec& mpc, double repeated, Diagnostics& out) {
  constexpr double kShortestTick = 1e-6, kMostSteps = 1e7, kLongest = 1e6;
  if (mpc.tick.value < kShortestTick)
    out.error(mpc.tick.place, fmt::format("a tick is at least {:g} s long", kShortestTick));
  double step = mpc.tick.value;
  if (mpc.plant.dt) step = std::min(step, mpc.plant.dt->value);
  if (const auto period = feedback_period(mpc)) step = std::min(step, period->value);
  if (mpc.repeat.value != AfterTheEnd::kNone) step = std::min(step, repeated);
  if (mpc.duration.value / step > kMostSteps)
    out.error(mpc.duration.place,
              fmt::format("{:g} s are more than {:g} steps of {:g} s", mpc.duration.value,
                          kMostSteps, step),
              "take a shorter duration, or longer ticks and steps");
  else if (mpc.duration.value + mpc.horizon.value > kLongest)
    out.error(mpc.duration.place,
              fmt::format("duration and horizon are more than {:g} s in all", kLongest));
}

/// Times and lengths of a loop that may divide knots.
std::vector<Located<double>> cutting_times(const MpcSpec& mpc) {
  std::vector<Located<double>> times = {mpc.horizon, mpc.tick, mpc.delay, mpc.duration};
  if (mpc.plant.dt) times.push_back(*mpc.plant.dt);
  if (const auto period = feedback_period(mpc)) times.push_back(*period);
  for (const DisturbanceSpec& disturbance : mpc.disturbances) {
    times.push_back(disturbance.at);
    if (disturbance.push)
      times.push_back({disturbance.at.value + disturbance.duration, disturbance.place});
  }
  return times;
}

/// Systems that give the next state themselves, and contact-implicit steps, need whole knots that
/// begin at multiples of their length. Reports one error for each time that is not such a multiple.
void check_whole_knots(const ProblemSpec& spec, const ShootingProblem& problem, Diagnostics& out) {
  const MpcSpec& mpc = *spec.mpc;
  const char* const reason =
      spec.stepping ? "contact-implicit steps are whole" : "the system gives the next state itself";
  std::set<double> steps;
  for (int k = 0; k < problem.knots(); ++k) {
    const KnotView& view = problem.knot(k);
    const bool whole = spec.stepping || view.model->integrator() == Integrator::discrete;
    if (!whole || problem.takes_no_time(k)) continue;
    steps.insert(view.dt);
    if (is_multiple(problem.times()[k], view.dt)) continue;
    return out.error(spec.phases[view.phase].name.place,
                     fmt::format("{}: in a closed loop knots of {:g} s cannot begin at {:g} s",
                                 reason, view.dt, problem.times()[k]),
                     "let phases begin at multiples of their 'dt'");
  }
  const std::vector<Located<double>> times =
      spec.stepping ? std::vector{mpc.horizon, mpc.tick, mpc.delay} : cutting_times(mpc);
  for (const Located<double>& time : times) {
    const auto step = std::find_if(steps.begin(), steps.end(),
                                   [&](double dt) { return !is_multiple(time.value, dt); });
    if (step == steps.end()) continue;
    out.error(time.place, fmt::format("{}: {:g} s is no multiple of the knots' dt, {:g} s", reason,
                                      time.value, *step));
  }
}

void check_disturbances(const MpcSpec& mpc, Diagnostics& out) {
  const auto check = [&](const Located<double>& at) {
    if (!is_before(at.value, mpc.duration.value))
      out.error(at.place,
                fmt::format("the loop has ended by then: it lasts {:g} s", mpc.duration.value));
  };
  for (const DisturbanceSpec& disturbance : mpc.disturbances) check(disturbance.at);
  for (const LateSpec& late : mpc.late) check(late.at);
}

void check_times(const ProblemSpec& spec, const ShootingProblem& problem, Diagnostics& out) {
  const MpcSpec& mpc = *spec.mpc;
  check_steps(mpc, repeated_step(problem), out);
  check_window(mpc, repeated_step(problem), out);
  check_disturbances(mpc, out);
  if (mpc.tick.value > mpc.horizon.value)
    out.error(mpc.tick.place, fmt::format("a tick of {:g} s is longer than the horizon of {:g} s",
                                          mpc.tick.value, mpc.horizon.value));
  if (mpc.delay.value > mpc.tick.value)
    out.error(mpc.delay.place,
              fmt::format("a delay of {:g} s is longer than the tick of {:g} s", mpc.delay.value,
                          mpc.tick.value),
              "take a tick as long as the delay; or for whole ticks a system whose states remember "
              "former controls: 'next: {..., u1: u, u2: u1}', with u2 in the place of u");
  const double end = problem.times().back();
  if (mpc.repeat.value == AfterTheEnd::kNone && is_before(end, mpc.duration.value))
    out.error(mpc.duration.place,
              fmt::format("the phases end at {:g} s, and nothing repeats them", end),
              "take a shorter duration, or 'repeat: hold'");
  check_whole_knots(spec, problem, out);
}

/// Reports constraints that no window would contain. Constraints on the state alone are inactive in
/// the first knot, whose state is given; they have no effect if this knot is the repeated one.
void check_held_constraints(const ProblemSpec& spec, const ShootingProblem& problem,
                            Diagnostics& out) {
  if (spec.mpc->repeat.value == AfterTheEnd::kNone || repeated_knot(problem) > 0) return;
  const KnotView& knot = problem.knot(0);
  for (const ConstraintTerm& term : knot.model->constraints()) {
    if (knot.parameters[term.active()] != 0 || term.depends_on_control(problem.ndx())) continue;
    const auto named = std::ranges::find_if(spec.constraints, [&](const ConstraintSpec& c) {
      return c.function.name.value == term.name;
    });
    if (named != spec.constraints.end())
      out.error(named->function.name.place,
                fmt::format("the constraint '{}' has no effect at repeated knots: the only one is "
                            "the first, whose state is given",
                            term.name),
                "give the phases two knots at least");
  }
}

/// The first of `solvers` if it supports windows with this last node. Otherwise, with `auto`, the
/// first of its solvers for such windows that also supports the problem. Null, with a report, if no
/// solver does both.
const SolverInfo* solver_of_windows(const std::vector<const SolverInfo*>& solvers,
                                    const ProblemSpec& spec, const ShootingProblem& problem,
                                    const Phase& end, Diagnostics& out) {
  const ShootingProblem windows(problem.initial_state(), problem.phases(), end);
  const auto reason = unsupported(*solvers.front(), windows);
  if (!reason) return solvers.front();
  if (find_solver(spec.solver.name.value) == nullptr)
    for (const SolverInfo* solver : auto_solvers(windows, spec.solver.options))
      if (!unsupported(*solver, problem)) return solver;
  const bool has_set = spec.mpc->terminal_lqr && spec.mpc->terminal_lqr->set;
  out.error(has_set ? spec.mpc->terminal_lqr->set_place : spec.mpc->window_end.place, *reason,
            "choose one of them with --solver, or leave 'set' out");
  return nullptr;
}

/// The first solver that supports the problem and its windows, whose last node is `end` if given.
/// Reports the key `iterations` if that solver lacks real-time iterations.
std::string solver_of(const BuiltProblem& built, const std::optional<Phase>& end,
                      Diagnostics& out) {
  const ProblemSpec& spec = *built.problem_spec;
  const auto solvers = usable_solvers(built, out);
  if (solvers.empty()) return {};
  const SolverInfo* solver =
      end ? solver_of_windows(solvers, spec, *built.problem, *end, out) : solvers.front();
  if (solver == nullptr) return {};
  const std::string name(solver->name);
  if (spec.mpc->iterations && !solver->real_time)
    out.error(
        spec.mpc->iterations_place,
        fmt::format("{} has no real-time iteration: it solves each window to the tolerances", name),
        "write 'iterations: tolerances', or leave the key out");
  return name;
}

/// Largest acceleration in a state (or rate, for a system without velocities), without clock and
/// parameters. 0 for systems that give the next state themselves.
double largest_rate(const System& system, const std::vector<double>& x, const Eigen::VectorXd& u) {
  if (system.kind() != SystemKind::second_order && system.kind() != SystemKind::first_order)
    return 0;
  const auto data = system.create_data(double{});
  system.evaluate(x.data(), u.data(), *data);
  Eigen::VectorXd rates = Eigen::Map<const Eigen::VectorXd>(data->f.data(), system.rows());
  for (const int i : other_coordinates(system))
    if (i < rates.size()) rates[i] = 0;
  return rates.cwiseAbs().maxCoeff();
}

/// Reports a state of the fallback that is not at rest.
void check_rest(const std::vector<double>& x, const Place& place, const BuiltProblem& built,
                Diagnostics& out) {
  const System& system = *built.plant.system;
  if (system.kind() != SystemKind::second_order) return;
  const std::vector<int> others = other_coordinates(system);
  for (int i = 0; i < system.nv(); ++i) {
    const int column = system.nq() + i;
    const bool is_other = std::find(others.begin(), others.end(), system.nv() + i) != others.end();
    if (x[column] == 0 || is_other) continue;
    return out.error(place,
                     fmt::format("the state of the fallback is not at rest: '{}' is {:g}",
                                 built.state_columns[column].name, x[column]),
                     "leave velocities out: they are 0 then");
  }
}

/// A system at rest in a state, held by the controls that balance it.
std::optional<HeldState> held_state(const FallbackSpec& fallback, const BuiltProblem& built,
                                    Diagnostics& out) {
  const Place& place = fallback.place;
  const ShootingProblem& problem = *built.problem;
  StateBuilder states(built.plant, out);
  const int own = built.plant.system->nx();
  states.set_initial({problem.initial_state().begin(), problem.initial_state().begin() + own});
  const auto x = fallback.name ? states.named(*fallback.name) : states.build(fallback.to);
  if (!x) return std::nullopt;
  check_rest(*x, place, built, out);
  const KnotModel& model = *problem.knot(repeated_knot(problem)).model;
  const System& system = model.system();
  HeldState held{*x, quasi_static_control(system, x->data()), {}};
  for (int i = 0; i < static_cast<int>(held.u.size()); ++i)
    held.u[i] = std::clamp(held.u[i], model.control_lower()[i], model.control_upper()[i]);
  constexpr double kNearlyAtRest = 1e-3;
  if (const double rate = largest_rate(system, *x, held.u); !(rate <= kNearlyAtRest))
    out.warning(
        place,
        fmt::format("the state of the fallback is no equilibrium: with the controls "
                    "that hold it best its largest {} is {:.3g}",
                    system.kind() == SystemKind::second_order ? "acceleration" : "rate", rate));
  held.K.setZero(held.u.size(), problem.ndx());
  held.x.resize(model.nx(), 0.0);
  model.step().hand_on(held.u.data(), held.x.data());
  return held;
}

/// Sets the last node of windows that end before the phases do. Returns the state of a moving
/// regulator at the start of the gait's path; empty if no regulator moves with the gait.
std::vector<double> set_window_end(const ProblemSpec& spec, const BuiltProblem& built,
                                   MpcOptions& controller, Diagnostics& out) {
  const WindowEnd end = spec.mpc->window_end.value;
  if (end == WindowEnd::kTerminal) controller.terminal = built.problem->terminal();
  if (end != WindowEnd::kRegulator) return {};
  auto regulator = build_loop_regulator(*spec.mpc->terminal_lqr, spec, built, out);
  if (!regulator) return {};
  controller.terminal = std::move(regulator->end);
  controller.terminal_path =
      path_along(spec.gait_way, built.problem->times(), regulator->start, built.plant);
  return std::move(regulator->start);
}

/// Warns if windows end along a gait whose terminal cost pulls to the end of its path.
void warn_of_way_ends(const ProblemSpec& spec, const ShootingProblem& problem, Diagnostics& out) {
  const MpcSpec& mpc = *spec.mpc;
  if (mpc.window_end.value != WindowEnd::kTerminal || !has_gait(spec) ||
      !is_before(mpc.horizon.value, problem.times().back()))
    return;
  for (const CostSpec& cost : spec.terminal_costs)
    if (cost.reference && !cost.reference->values.empty() && cost.reference->values.front().state &&
        cost.reference->values.front().state->displaced)
      return out.warning(mpc.window_end.place,
                         fmt::format("'terminal: keep' pulls every window to the end of the gait's "
                                     "path, where the terminal cost '{}' has its reference",
                                     cost.name.value),
                         "leave 'terminal' out");
}

/// The controller that takes over after failed ticks.
std::optional<HeldState> fallback_of(const FallbackSpec& fallback, const ProblemSpec& spec,
                                     const BuiltProblem& built, Diagnostics& out) {
  if (!fallback.by_lqr) return held_state(fallback, built, out);
  const auto regulator = build_loop_regulator(*fallback.by_lqr, spec, built, out);
  if (!regulator) return std::nullopt;
  const TerminalIngredients& about = regulator->ingredients;
  HeldState held{about.x, about.u, -about.K};
  if (!regulator->start.empty())
    held.settle = [&plant = built.plant](const double* x, std::vector<double>& to) {
      bring_base(plant, plant.parts.front(), {x, x + to.size()}, to);
    };
  return held;
}

/// Changes of the plant over time, each a separate problem.
class PlantBuilder {
 public:
  PlantBuilder(const ProblemSpec& spec, const BuiltProblem& built, BuiltMpc& to, Diagnostics& out)
      : spec_(spec), mpc_(*spec.mpc), built_(built), to_(to), out_(out), of_plant_(out) {}

  void build() {
    const std::set<double> times = changes();
    if (mpc_.plant.simulated_contacts && mpc_.plant.integrator)
      out_.warning(mpc_.plant.integrator->place,
                   "'integrator' has no effect: simulated contacts have an integrator of their own",
                   "leave the key out");
    if (mpc_.plant.settings.empty() && times.size() == 1 && !mpc_.plant.simulated_contacts)
      return;  // the plant is the model
    ProblemSpec changed = spec_;
    if (!mpc_.plant.settings.empty() && !apply_settings(changed)) return;
    for (const double time : times) {
      ProblemSpec spec = changed;
      const bool pushed = push(time, spec);
      if (!add(time, std::move(spec), pushed)) return;
    }
  }

 private:
  /// Applies the settings of the plant to the problem file.
  bool apply_settings(ProblemSpec& changed) {
    auto document = parse_problem(spec_.text, spec_.file, of_plant_);
    std::vector<Setting> settings = parse_settings(spec_.settings, of_plant_);
    settings.insert(settings.end(), mpc_.plant.settings.begin(), mpc_.plant.settings.end());
    auto read = document ? read_problem(*document, settings, of_plant_) : std::nullopt;
    if (read) {
      changed = *std::move(read);
      changed.mpc = spec_.mpc;  // its places refer to the texts of the loop's diagnostics
    }
    return report(of_plant_, read.has_value()) && check_constraints(changed);
  }

  /// The only constraints of a plant are the limits of its actuators.
  bool check_constraints(const ProblemSpec& changed) {
    const int errors = out_.error_count();
    constexpr std::string_view kSection = "constraints.";
    for (const Setting& setting : mpc_.plant.settings) {
      const std::string& key = setting.key.value;
      const auto is_inside = [&](const ConstraintSpec& bounds) {
        const std::string own = std::string(kSection) + bounds.function.name.value;
        return key == own || key.starts_with(own + '.');
      };
      if (key.starts_with(kSection) &&
          std::none_of(changed.control_bounds.begin(), changed.control_bounds.end(), is_inside))
        out_.error(setting.key.place,
                   "the only constraints of a plant are hard bounds on the control",
                   "name an entry with 'bounds: control', or write one: "
                   "'constraints.motors: {bounds: control, lower: -1, upper: 1}'");
    }
    return out_.error_count() == errors;
  }

  /// Place of the setting at or above the path of a diagnostic, else of one below it, else of the
  /// only setting, else of the plant.
  const Place& place_of(const Diagnostic& fault) const {
    const std::string path = fault.path + '.';
    for (const Setting& setting : mpc_.plant.settings)
      if (path.starts_with(setting.key.value + '.')) return setting.key.place;
    for (const Setting& setting : mpc_.plant.settings)
      if ((setting.key.value + '.').starts_with(path)) return setting.key.place;
    return mpc_.plant.settings.size() == 1 ? mpc_.plant.settings[0].key.place : mpc_.plant.place;
  }

  /// Reports the first error of a changed problem at the setting that causes it.
  bool report(const Diagnostics& own, bool fine) {
    const Diagnostic* fault = first_error(own);
    if (fault == nullptr) return fine;
    out_.error(place_of(*fault), fmt::format("the plant cannot be built: {}", fault->message),
               fault->hint);
    return false;
  }

  static const Diagnostic* first_error(const Diagnostics& out) {
    for (const Diagnostic& fault : out.list())
      if (fault.severity == Severity::kError) return &fault;
    return nullptr;
  }

  /// Begin and end times of pushes, and 0.
  std::set<double> changes() const {
    std::set<double> times = {0};
    for (const DisturbanceSpec& disturbance : mpc_.disturbances)
      if (disturbance.push)
        times.insert({disturbance.at.value, disturbance.at.value + disturbance.duration});
    return times;
  }

  /// Applies the pushes of a time to the robots. True if there are any.
  bool push(double time, ProblemSpec& spec) {
    bool pushed = false;
    for (const DisturbanceSpec& disturbance : mpc_.disturbances) {
      if (!disturbance.push || is_before(time, disturbance.at.value) ||
          !is_before(time, disturbance.at.value + disturbance.duration))
        continue;
      pushed = true;
      WrenchSpec wrench = *disturbance.push;
      if (RobotSpec* robot = robot_of(spec, wrench)) robot->external_wrenches.push_back(wrench);
    }
    return pushed;
  }

  /// Robot with the frame of a wrench; removes the robot's name from that of the frame.
  RobotSpec* robot_of(ProblemSpec& spec, WrenchSpec& wrench) {
    for (RobotSpec& robot : spec.robots) {
      const std::string prefix = robot.name.value.empty() ? "" : robot.name.value + "/";
      if (!wrench.frame.value.starts_with(prefix)) continue;
      wrench.frame.value.erase(0, prefix.size());
      return &robot;
    }
    out_.error(wrench.frame.place, fmt::format("no robot has a frame '{}'", wrench.frame.value),
               spec.robots.empty() ? "a closed-form system has no frames: write 'jump'" : "");
    return nullptr;
  }

  bool add(double time, ProblemSpec spec, bool pushed) {
    if (out_.has_errors()) return false;
    spec.guess = {};
    spec.terminal_lqr.reset();  // the plant need not hold the regulator's equilibrium
    Diagnostics own = of_plant_;
    const auto built = build_without_homotopy(std::move(spec), {}, own);
    if (pushed && own.has_errors()) {
      out_.add(*first_error(own));  // at the name of the push
      return false;
    }
    if (!report(own, built.has_value())) return false;
    if (!same_columns(*built) || built->problem->times() != built_.problem->times()) {
      out_.error(mpc_.plant.place, "the plant has other states, controls or times than the model",
                 "change numbers alone: masses, lengths, gravity, bounds on the control");
      return false;
    }
    if (to_.loop.plant.empty()) list_files(*built);
    std::shared_ptr<PlantMotion> motion;
    if (mpc_.plant.simulated_contacts) {
      motion = simulated_plant(*built, out_);
      if (motion == nullptr) return false;
      if (time == 0) check_standing(*built, out_);
    }
    to_.loop.plant.push_back({time, built->problem, std::move(motion)});
    return true;
  }

  void list_files(const BuiltProblem& plant) {
    for (const PlantPart& part : plant.plant.parts)
      to_.plant_files.push_back({part.spec->path.string(), part.sha256});
    to_.plant_files.insert(to_.plant_files.end(), plant.data_files.begin(), plant.data_files.end());
  }

  bool same_columns(const BuiltProblem& plant) const {
    const auto same = [](const std::vector<Column>& a, const std::vector<Column>& b) {
      return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                        [](const Column& x, const Column& y) { return x.name == y.name; });
    };
    return same(plant.state_columns, built_.state_columns) &&
           same(plant.control_columns, built_.control_columns);
  }

  const ProblemSpec& spec_;
  const MpcSpec& mpc_;
  const BuiltProblem& built_;
  BuiltMpc& to_;
  Diagnostics& out_;
  Diagnostics of_plant_;  ///< for the problem with the plant's settings, including its text
};

/// True if a condition varies with time.
bool changes_with_time(const ConstraintSpec& condition, const ProblemSpec& spec,
                       const BuiltProblem& built, const Diagnostics& out) {
  const CostSpec& function = condition.function;
  if (function.reference && (function.reference->values.size() > 1 || function.reference->file))
    return true;
  if (condition.bounded || function.definition->of_contacts()) return false;
  Diagnostics own = out;  // errors are reported when the condition is built
  const auto residual = make_cost_residual(function, spec, built.plant, built.problem->ndx(), own);
  return residual && residual->time != TimeParameters::kNone;
}

/// Reports a condition without bounds, which would require a residual of exactly zero.
void check_condition(const ConstraintSpec& condition, Diagnostics& out) {
  if (is_zero(condition) && !condition.function.definition->of_contacts())
    out.error(condition.function.name.place,
              fmt::format("the condition '{}' has no bounds within which the loop continues",
                          condition.function.name.value),
              "give 'lower' or 'upper', or 'at_least' or 'at_most' for the norm");
}

/// Conditions that end the loop, as the last node of a problem without other constraints.
std::optional<StopCondition> stop_condition(const ProblemSpec& spec, const BuiltProblem& built,
                                            Diagnostics& out) {
  for (const ConstraintSpec& condition : spec.mpc->stop_when) {
    check_condition(condition, out);
    if (changes_with_time(condition, spec, built, out))
      out.error(condition.function.name.place,
                "a condition that ends the loop does not change with time",
                "give it one reference, and rows without 't'");
  }
  ProblemSpec alone = spec;
  alone.constraints.clear();
  alone.terminal_costs.clear();
  alone.terminal_lqr.reset();
  alone.terminal_constraints = spec.mpc->stop_when;
  alone.guess = {};
  Diagnostics own = out;  // avoids repeated reports
  const auto problem = build_without_homotopy(std::move(alone), {.plant = &built.plant}, own);
  if (own.has_errors()) out = own;
  if (!problem) return std::nullopt;
  const Phase& end = problem->problem->terminal();
  return StopCondition{end.model, end.parameters};
}

void set_disturbances(const MpcSpec& mpc, const BuiltProblem& built, ClosedLoopOptions& loop,
                      Diagnostics& out) {
  for (const DisturbanceSpec& disturbance : mpc.disturbances)
    if (disturbance.jump)
      loop.jumps.push_back({disturbance.at.value, tangent_numbers(disturbance.jump, built, out)});
  std::stable_sort(loop.jumps.begin(), loop.jumps.end(),
                   [](const Jump& a, const Jump& b) { return a.at < b.at; });
  if (mpc.noise) loop.noise = {tangent_numbers(mpc.noise->sigma, built, out), mpc.noise->seed};
}

/// Reports a plant that cannot be integrated with its integrator and step.
void check_plant(const MpcSpec& mpc, const BuiltProblem& built, const StepRule& rule,
                 Diagnostics& out) {
  try {
    const TimeLine line(built.problem, mpc.repeat.value != AfterTheEnd::kNone);
    const Simulation simulation(line, rule);
  } catch (const std::invalid_argument& reason) {
    const bool discrete = built.plant.system->kind() == SystemKind::discrete;
    out.error(mpc.plant.integrator ? mpc.plant.integrator->place : mpc.place, reason.what(),
              discrete ? "leave the key out: the system gives the next state itself"
                       : "take explicit_euler, rk2, rk3 or rk4");
  }
}

/// Reports windows whose solvers exceed the memory; each structure of windows keeps its own solver.
void check_memory_of_windows(const ProblemSpec& spec, const BuiltProblem& built,
                             const BuiltMpc& loop, Diagnostics& out) {
  // A kept solver can use exact Hessians and retries, and a window holds two plans. On legged
  // robots, we measured 1.4 to 3.5 times the memory of one solve.
  constexpr double kOfASolve = 3;
  const WindowCount count = count_windows(built.problem, loop.controller, loop.loop.duration);
  const int ndx = built.problem->ndx(), nu = static_cast<int>(built.control_columns.size());
  const double need =
      count.structures * kOfASolve *
      memory_need(count.knots, ndx, nu, spec.costs.size(), count_constraints(spec, ndx, nu));
  const double there = memory_there();
  if (need > there)
    out.error(spec.mpc->horizon.place,
              fmt::format("{} structures of windows, with up to {} knots, need about {:.3g} GiB of "
                          "memory, and there are {:.3g}",
                          count.structures, count.knots, need / kGiB, there / kGiB),
              "take a shorter horizon or duration, or longer ticks");
}

MpcOptions controller_of(const MpcSpec& mpc, const SolverSpec& solver) {
  MpcOptions options{.horizon = mpc.horizon.value,
                     .tick = mpc.tick.value,
                     .iterations = mpc.iterations,
                     .hold = mpc.repeat.value != AfterTheEnd::kNone,
                     .delay = mpc.delay.value};
  if (mpc.feedback_rate) options.feedback_rate = mpc.feedback_rate->value;
  options.solver_options = solver.options;
  return options;
}

/// Duration of all phases, s.
double total_duration(const ProblemSpec& spec) {
  double sum = 0;
  for (const PhaseSpec& phase : spec.phases) sum += phase_duration(phase);
  return sum;
}

/// The file with a given number of cycles of its gait.
std::optional<ProblemSpec> with_cycles(const ProblemSpec& spec, int cycles, Diagnostics& out) {
  std::vector<std::string> settings = spec.settings;
  settings.push_back(fmt::format("gait.cycles={}", cycles));
  auto read = read_problem_text(spec.text, spec.file, settings, out);
  if (!read) return read;
  read->sha256 = spec.sha256;
  read->mpc->repeat.value = AfterTheEnd::kHold;  // the given number of cycles suffices
  return read;
}

/// Shortest duration of a gait cycle if each of its touch-downs may be early, s.
double shortest_cycle(const MpcSpec& mpc, double cycle, int touch_downs) {
  if (!mpc.retime) return cycle;
  return std::max(cycle - touch_downs * mpc.retime->early.value, std::min(cycle, mpc.tick.value));
}

/// Maximum number of gait cycles. `first` counts the knots of a file with one cycle, `other` those
/// of each additional cycle.
int most_cycles(int first, int other) {
  return std::min(kMostGaitCycles, 1 + (kMaxKnots - first) / other);
}

/// The problem with as many gait cycles as a loop with `repeat: gait` needs, read again from the
/// text of its file. Empty, with a report, if it lacks a gait or needs too many cycles.
std::optional<ProblemSpec> repeat_gait(const ProblemSpec& spec, Diagnostics& out) {
  const MpcSpec& mpc = *spec.mpc;
  Diagnostics attempt;
  const auto once = with_cycles(spec, 1, attempt), twice = with_cycles(spec, 2, attempt);
  const double cycle = once && twice ? total_duration(*twice) - total_duration(*once) : 0;
  if (!(cycle > 0)) {
    out.error(mpc.repeat.place, "the file has no gait whose cycles could be repeated",
              "write 'repeat: hold'");
    return std::nullopt;
  }
  const double needed = mpc.duration.value + mpc.delay.value + mpc.horizon.value;
  const double least =
      shortest_cycle(mpc, cycle, count_touch_downs(*twice) - count_touch_downs(*once));
  const double first = total_duration(*once) - (cycle - least);
  const double cycles = 2 + std::floor(std::max(0.0, (needed - first) / least));
  if (cycles > most_cycles(once->knots(), twice->knots() - once->knots())) {
    out.error(mpc.duration.place,
              fmt::format("{:g} s are {:g} cycles of the gait, more than a file can have",
                          mpc.duration.value, cycles),
              "take a shorter duration");
    return std::nullopt;
  }
  return with_cycles(spec, static_cast<int>(cycles), out);
}

}  // namespace

std::optional<BuiltMpc> build_mpc(const BuiltProblem& built, Diagnostics& out) {
  const ProblemSpec& spec = *built.problem_spec;
  const MpcSpec& mpc = *spec.mpc;
  const int errors = out.error_count();
  check_problem(spec, out);
  check_times(spec, *built.problem, out);
  check_held_constraints(spec, *built.problem, out);
  if (!built.plant.variants.empty())
    out.error(
        mpc.place,
        "windows of a closed loop have one set of states and controls, and these phases differ",
        "give all 'systems' the same ones");
  BuiltMpc result{.controller = controller_of(mpc, spec.solver)};
  result.loop.duration = mpc.duration.value;
  if (mpc.plant.integrator) result.loop.step.integrator = mpc.plant.integrator->value;
  if (mpc.plant.dt) result.loop.step.dt = mpc.plant.dt->value;
  if (out.error_count() > errors) return std::nullopt;
  check_plant(mpc, built, result.loop.step, out);
  const std::vector<double> led = set_window_end(spec, built, result.controller, out);
  result.controller.solver = solver_of(built, result.controller.terminal, out);
  if (mpc.fallback) {
    result.controller.fallback = fallback_of(*mpc.fallback, spec, built, out);
    result.controller.fallback_after = mpc.fallback->after;
  }
  warn_of_way_ends(spec, *built.problem, out);
  set_disturbances(mpc, built, result.loop, out);
  result.controller.is_late = late_ticks(mpc);
  if (built.plant.stepping())
    result.controller.simulate_guess = [](const ShootingProblem& window, const Feedback& policy,
                                          Trajectory& guess) {
      if (auto motion = simulated_guess(window, guess, &policy)) guess = *std::move(motion);
    };
  result.controller.swings = build_loop_swings(spec, built, out);
  result.controller.retiming = build_retiming(spec, built, out);
  result.loop.commands = build_commands(spec, built, led, out);
  if (!mpc.stop_when.empty()) result.loop.stop = stop_condition(spec, built, out);
  if (out.error_count() > errors) return std::nullopt;
  check_memory_of_windows(spec, built, result, out);
  PlantBuilder(spec, built, result, out).build();
  if (out.error_count() > errors) return std::nullopt;
  return result;
}

std::unique_ptr<LoopTask> build_loop(std::optional<ProblemSpec> spec, const BuildOptions& options,
                                     Diagnostics& out) {
  if (!spec) return nullptr;
  if (!spec->mpc) {
    out.error({}, fmt::format("{} has no section 'mpc'", spec->file.string()),
              "write 'mpc: {horizon: 1, tick: 0.02, duration: 5}'");
    return nullptr;
  }
  if (spec->mpc->repeat.value == AfterTheEnd::kGait) spec = repeat_gait(*spec, out);
  auto built = build_problem(std::move(spec), options, out);
  if (!built) return nullptr;
  auto task = std::make_unique<LoopTask>(LoopTask{*std::move(built), {}});
  auto mpc = build_mpc(task->built, out);
  if (!mpc) return nullptr;
  task->mpc = *std::move(mpc);
  return task;
}

std::unique_ptr<LoopTask> build_loop(const BuiltProblem& built, const BuildOptions& options,
                                     Diagnostics& out) {
  return build_loop(*built.problem_spec, options, out);
}

}  // namespace conddp
