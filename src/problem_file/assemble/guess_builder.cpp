#include "problem_file/assemble/guess_builder.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "base/exceeds.hpp"
#include "base/random_numbers.hpp"
#include "base/text/spelling.hpp"
#include "ocp/problem/by_name.hpp"
#include "problem_file/assemble/contact_guess.hpp"
#include "problem_file/data/data_table.hpp"
#include "problem_file/motion/quasi_static.hpp"
#include "problem_file/plant/collocation_builder.hpp"
#include "problem_file/terms/constraint_builder.hpp"
#include "problem_file/terms/terminal_lqr.hpp"
#include "systems/system.hpp"

namespace conddp {
namespace {

using States = GuessSpec::States;
using Controls = GuessSpec::Controls;

constexpr std::size_t kShownNames = 12;

class GuessBuilder {
 public:
  GuessBuilder(const GuessContext& context, GuessUsed& used, Diagnostics& out)
      : spec_(context.spec),
        plant_(context.plant),
        states_(context.states),
        problem_(context.problem),
        columns_(context.problem),
        used_(used),
        out_(out) {}

  std::optional<Trajectory> build() {
    Trajectory guess = problem_.create_trajectory();
    const int errors = out_.error_count();
    fill_states(guess);
    if (out_.error_count() == errors) fill_controls(guess);
    if (out_.error_count() > errors) return std::nullopt;
    if (chooses()) choose_start(guess);
    carry_memory(guess);
    guess_slopes(problem_, guess);
    return guess;
  }

 private:
  const GuessSpec& guess() const { return spec_.guess; }
  bool chooses() const { return problem_.phases().front().instant; }
  /// System whose controls are guessed; the slopes of collocation follow from them and the states.
  static const System& guessed(const System& system) {
    const auto* collocation = system.as_collocation();
    return collocation ? *collocation->inside() : system;
  }
  /// A control vector to guess, possibly only its first entries, with its knot and its node.
  struct ControlAt {
    Eigen::Map<Eigen::VectorXd> u;
    int knot, node;
  };
  std::vector<ControlAt> controls(Trajectory& trajectory) const {
    std::vector<ControlAt> list;
    const bool linear = spec_.has_linear_controls();
    if (linear && chooses() && !spec_.initial_state.previous_control) {
      auto choice = trajectory.u(0);
      const int count = plant_.actuated().nu();
      list.push_back({{choice.data() + choice.size() - count, count}, 1, 1});
    }
    for (const int k : controlled_knots()) list.push_back({trajectory.u(k), k, linear ? k + 1 : k});
    return list;
  }
  /// Knots whose controls are guessed: all with controls, except the choice of the start.
  std::vector<int> controlled_knots() const {
    std::vector<int> knots;
    for (int k = chooses() ? 1 : 0; k < problem_.knots(); ++k)
      if (problem_.nu(k) > 0) knots.push_back(k);
    return knots;
  }

  /// Chooses the displacement from the initial state to the guess of the next one, within its
  /// bounds.
  void choose_start(Trajectory& trajectory) const {
    const StateManifold& manifold = plant_.system->manifold();
    const KnotModel& model = *problem_.knot(0).model;
    Eigen::VectorXd off(manifold.ndx());
    manifold.difference(trajectory.x(0).data(), trajectory.x(1).data(), off.data());
    Eigen::VectorXd asked = trajectory.u(0);  // the first linear controls are set already
    if (!spec_.has_linear_controls())
      for (int i = 0; i < model.step().tail(); ++i)
        if (const auto control = model.step().source(i))
          asked[*control] = trajectory.x(0)[plant_.system->nx() + i];
    for (std::size_t i = 0; i < plant_.start->coordinates.size(); ++i)
      asked[i] = off[plant_.start->coordinates[i]];
    for (std::size_t p = 0; p < problem_.phases().size(); ++p)
      if (const auto& free = problem_.phases()[p].model->step().duration())
        asked[*model.step().source(free->choice)] =
            durations_.empty() ? free->written : durations_[p];
    for (int i = 0; i < problem_.nu(0); ++i)
      trajectory.u(0)[i] = std::clamp(asked[i], model.control_lower()[i], model.control_upper()[i]);
    set_duration_states(trajectory);
  }
  /// Sets states that are durations to the chosen durations.
  void set_duration_states(Trajectory& trajectory) const {
    const std::vector<Column>& states = plant_.system->state_columns();
    const std::vector<Column>& choices = problem_.knot(0).model->system().control_columns();
    for (std::size_t i = 0; i < states.size(); ++i) {
      const auto choice = std::ranges::find(choices, states[i].name, &Column::name);
      if (!states[i].name.starts_with(kDurationColumn) || choice == choices.end()) continue;
      for (int k = 1; k <= problem_.knots(); ++k)
        trajectory.x(k)[i] = trajectory.u(0)[choice - choices.begin()];
    }
  }
  double time(int k) const { return problem_.times()[k]; }
  /// Number of nodes after node k at the same time.
  int later_nodes_at_time(int k) const {
    int count = 0;
    while (k + count < problem_.knots() && problem_.takes_no_time(k + count)) ++count;
    return count;
  }

  /// Propagates the choice of the start and held controls through the states; integrals are guessed
  /// elsewhere.
  void carry_memory(Trajectory& trajectory) const {
    const int own = plant_.system->nx() + static_cast<int>(spec_.integrals.size());
    for (int k = 1; k <= problem_.knots(); ++k) {
      const int tail = problem_.nx() - own;
      trajectory.x(k).tail(tail) = trajectory.x(k - 1).tail(tail);
      problem_.knot(k - 1).model->step().hand_on(trajectory.u(k - 1).data(),
                                                 trajectory.x(k).data());
    }
  }

  void fill_states(Trajectory& trajectory) {
    const StateManifold& manifold = plant_.system->manifold();
    std::optional<TimeSeries> series;
    switch (guess().states) {
      case States::kInitial:
        used_.states = "the initial state at every knot";
        return;
      case States::kInterpolate:
        series = towards_target();
        break;
      case States::kKeyframes:
        series = through_keyframes();
        break;
      case States::kFile:
        series = from_file(*guess().states_file, true, file_columns(*guess().states_file, true),
                           manifold);
        if (series) used_.states = describe(*guess().states_file, {*series});
        break;
    }
    if (!series) return;
    for (int k = 1; k <= problem_.knots(); ++k) {
      const std::vector<double> x = series->interpolate(time(k), later_nodes_at_time(k));
      trajectory.x(k).head(x.size()) = Eigen::Map<const Eigen::VectorXd>(x.data(), x.size());
    }
  }

  /// Path from the initial state to the target of the terminal costs, overridden by equalities at
  /// the last node.
  std::optional<TimeSeries> towards_target() {
    const std::vector<double>& times = problem_.times();
    std::vector<double> target = states_.initial();
    bool found = spec_.terminal_lqr.has_value();
    if (found) {
      const auto state = equilibrium_of(*spec_.terminal_lqr, states_);
      if (!state) return std::nullopt;
      target = *state;
    }
    for (const CostSpec& cost : spec_.terminal_costs) {
      if (!cost.definition->of_positions) continue;
      const auto known = set_target(cost, {}, target);
      if (!known) return std::nullopt;
      found |= *known;
    }
    bool constrained = false;
    for (const ConstraintSpec& constraint : spec_.terminal_constraints) {
      if (!constraint.function.definition->of_positions) continue;
      if (!is_zero(constraint) && !constraint.equals) continue;
      const auto known = set_target(constraint.function, constraint.equals, target);
      if (!known) return std::nullopt;
      constrained |= *known;
    }
    if (!found && !constrained) {
      out_.error(guess().states_place,
                 "to interpolate, the guess needs a terminal cost or equality on the state or on "
                 "joint positions",
                 "give one, or use keyframes");
      return std::nullopt;
    }
    used_.states = fmt::format("from the initial state straight to the target of the terminal {}",
                               constrained ? "constraints" : "costs");
    TimeSeries series(plant_.system->manifold(), states_.initial());
    series.append(times.back(), std::move(target));
    return series;
  }

  /// Writes the last reference of a residual on positions, plus the value its rows must equal, into
  /// its entries of the target state. False if nothing is written: equalities on rotation rows do
  /// not define a state.
  std::optional<bool> set_target(const CostSpec& cost, const std::optional<ComponentsSpec>& equals,
                                 std::vector<double>& target) const {
    const std::vector<double>& times = problem_.times();
    const Plant plant = plant_.at_last_node();
    const auto residual = make_cost_residual(cost, spec_, plant, problem_.ndx(), out_);
    if (!residual) return std::nullopt;
    const auto reference = build_reference(cost, *residual, plant, states_, times, out_);
    const auto above = resolve(equals, residual->rows, std::nan(""), out_);
    if (!reference || !above) return std::nullopt;
    const std::vector<double> value = reference->interpolate(times.back());
    if (equals && above->size() != value.size()) return false;
    for (std::size_t i = 0; i < value.size(); ++i) {
      const double entry = equals ? value[i] + (*above)[i] : value[i];
      const std::size_t index = residual->indices.empty() ? i : residual->indices[i];
      if (!std::isnan(entry)) target[index] = entry;
    }
    return true;
  }

  std::optional<TimeSeries> through_keyframes() {
    TimeSeries series(plant_.system->manifold());
    bool good = true;
    for (const KeyframeSpec& keyframe : guess().keyframes) good &= append(keyframe, series);
    if (!good) return std::nullopt;
    const bool cubic = guess().interpolation == Interpolation::kCubic;
    if (cubic) series.make_cubic();
    used_.states = fmt::format("interpolated between {} keyframes{}", guess().keyframes.size(),
                               cubic ? " by a cubic spline" : "");
    return series;
  }

  /// Appends a keyframe; false, with an error, if it does not fit those before it.
  bool append(const KeyframeSpec& keyframe, TimeSeries& series) const {
    const double when = time_of(keyframe);
    if (series.empty() && when > 0) series.append(0, states_.initial());
    if (!series.empty() && when <= series.last_time()) {
      out_.error(keyframe.place, "keyframes must stand in the order of time");
      return false;
    }
    const auto state = states_.build(keyframe.state);
    if (state) series.append(when, *state);
    return state.has_value();
  }

  /// Time of a keyframe, s.
  double time_of(const KeyframeSpec& keyframe) const {
    if (keyframe.knot) return time(keyframe.knot->value);
    const double end = time(problem_.knots());
    if (keyframe.time->value > end * (1 + 1e-9))
      out_.warning(keyframe.time->place,
                   fmt::format("the motion ends at {:.6g} s, before this keyframe", end));
    return keyframe.time->value;
  }

  void fill_controls(Trajectory& trajectory) {
    if (plant_.stepping()) guess_contacts(plant_.stepping(), problem_, trajectory);
    switch (guess().controls) {
      case Controls::kZero:
        used_.controls = "zero";
        break;
      case Controls::kQuasiStatic:
        if (plant_.stepping())
          hold_by_contacts(trajectory);
        else
          hold_against_gravity(trajectory);
        break;
      case Controls::kConstant:
        fill_constant(trajectory);
        break;
      case Controls::kFile:
        fill_from_file(trajectory);
        break;
    }
    if (guess().random) add_noise(*guess().random, trajectory);
  }

  void hold_against_gravity(Trajectory& trajectory) {
    if (!plant_.multibody() && plant_.system->kind() != SystemKind::second_order)
      return out_.error(guess().controls_place,
                        "this system has no gravity that controls could hold it against");
    used_.controls = "those that hold the guessed states against gravity";
    const System* former = nullptr;
    Eigen::VectorXd state, control;
    for (ControlAt& at : controls(trajectory)) {
      const System& system = guessed(problem_.knot(at.knot).model->system());
      // Most guesses keep one state, so its control is reused.
      if (&system != former || state != trajectory.x(at.node)) {
        former = &system;
        state = trajectory.x(at.node);
        control = quasi_static_control(system, state.data());
      }
      at.u.head(system.nu()) = control;
    }
    keep_bounds(trajectory);
  }

  void fill_constant(Trajectory& trajectory) {
    const auto values = resolve(*guess().constant, names_of_controls(), 0.0, out_);
    if (!values) return;
    used_.controls = "constant";
    for (ControlAt& at : controls(trajectory)) set_control(*values, at);
  }

  /// Sets the controls of a knot, some or all of them, from the values of all guessed controls.
  void set_control(const std::vector<double>& values, ControlAt& at) const {
    const Eigen::Map<const Eigen::VectorXd> all(values.data(), values.size());
    if (!columns_.are_some(at.knot)) {
      at.u.head(all.size()) = all;
      return;
    }
    const std::vector<Column>& guessed = plant_.all_controls();
    const std::span<const int> columns = columns_.columns_of(at.knot);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const std::string& name = columns_.columns()[columns[i]].name;
      const auto found = std::ranges::find(guessed, name, &Column::name);
      if (found != guessed.end()) at.u[i] = values[found - guessed.begin()];
    }
  }

  void fill_from_file(Trajectory& trajectory) {
    const DataFileSpec& file = *guess().controls_file;
    const auto series = control_series(file);
    if (!series) return;
    used_.controls = describe(file, *series);
    for (ControlAt& at : controls(trajectory)) {
      std::vector<double> values;
      for (const TimeSeries& part : *series) {
        const std::vector<double> u = spec_.has_linear_controls() ? part.interpolate(time(at.node))
                                                                  : part.hold(time(at.node));
        values.insert(values.end(), u.begin(), u.end());
      }
      set_control(values, at);
    }
  }

  /// All controls of a file. If phases have different controls, each control is a separate series,
  /// since rows of other phases omit it.
  std::optional<std::vector<TimeSeries>> control_series(const DataFileSpec& file) {
    const std::vector<std::string> columns = file_columns(file, false);
    std::vector<std::vector<std::string>> groups{columns};
    if (!plant_.variants.empty()) {
      groups.clear();
      for (const std::string& column : columns) groups.push_back({column});
    }
    std::vector<TimeSeries> series;
    for (const std::vector<std::string>& group : groups) {
      auto part =
          from_file(file, false, group, StateManifold::flat(static_cast<int>(group.size())));
      if (!part) return std::nullopt;
      series.push_back(*std::move(part));
    }
    return series;
  }

  void add_noise(const GuessSpec::Random& random, Trajectory& trajectory) {
    used_.seed = random.seed;
    used_.controls +=
        fmt::format(", plus {} times normal random numbers of seed {}", random.scale, random.seed);
    NormalNumbers normal(random.seed);
    const int actuators = static_cast<int>(plant_.all_controls().size());
    for (ControlAt& at : controls(trajectory))
      for (int i = 0; i < std::min(static_cast<int>(at.u.size()), actuators); ++i)
        at.u[i] += random.scale * normal.next();
  }

  void hold_by_contacts(Trajectory& trajectory) {
    const HeldGuess held = guess_held_contacts(
        plant_.stepping(), problem_, spec_.solver.options.complementarity.initial, trajectory);
    used_.controls = "those that hold the guessed states together with contact forces";
    if (held.unheld > 0)
      used_.controls += fmt::format(
          " as far as they can: {} of {} steps have a residual, {:.3g} at most, in knot {}",
          held.unheld, held.steps, held.worst, held.worst_knot);
  }

  std::optional<TimeSeries> from_file(const DataFileSpec& file, bool states,
                                      const std::vector<std::string>& columns,
                                      const StateManifold& manifold) {
    const std::optional<DataTable>& table = load(file);
    if (!table || columns.empty() || (file.columns.empty() && !fits(file, *table, states)))
      return std::nullopt;
    return is_partial(file, states)
               ? series_of(file, with_others(*table, file, states), columns, manifold, out_)
               : series_of(file, *table, columns, manifold, out_);
  }

  /// Loads each file once, for states and controls.
  const std::optional<DataTable>& load(const DataFileSpec& file) {
    const auto [entry, fresh] = tables_.try_emplace(file.path);
    std::optional<DataTable>& table = entry->second;
    if (!fresh) return table;
    table = load_data_table(file.path, file.file.place, out_);
    if (table && !table->state_columns) add_clock(*table);
    if (table && table->state_columns && !take_durations(*table))
      warn_of_duration(file, table->times.back());
    return table;
  }

  /// Adds the clock, which follows from the time, to a CSV file of the other states.
  void add_clock(DataTable& table) const {
    const std::vector<Column>& states = plant_.system->state_columns();
    for (std::size_t i = 0; i < states.size(); ++i) {
      const bool rate = states[i].name == kClockRate;
      if (!states[i].by_name_only || !(rate || states[i].name == kClock)) continue;
      if (table.find(states[i].name)) continue;
      table.columns.push_back(states[i].name);
      for (std::size_t row = 0; row < table.rows.size(); ++row)
        table.rows[row].push_back(states_.initial()[i] + (rate ? 0 : table.times[row]));
    }
  }

  /// Takes the free durations from a former solution with the same phases, and maps its times to
  /// the phases of this problem. The number of knots may differ.
  bool take_durations(DataTable& table) {
    if (!problem_.has_free_durations() ||
        !std::ranges::equal(table.phases, problem_.phases(), {}, &FormerPhase::name, &Phase::name))
      return false;
    const std::vector<double> times = table.times;
    durations_.clear();
    int node = 0;
    for (const FormerPhase& former : table.phases) {
      const double begin = time(node), former_begin = times[former.first];
      node += problem_.phases()[durations_.size()].knots();
      const double lasted = times[former.last] - former_begin;
      durations_.push_back(lasted);
      for (std::size_t i = former.first; i < former.last; ++i)
        table.times[i] =
            lasted > 0 ? std::lerp(begin, time(node), (times[i] - former_begin) / lasted) : begin;
      table.times[former.last] = time(node);
    }
    return true;
  }

  void warn_of_duration(const DataFileSpec& file, double lasts) {
    const double wanted = time(problem_.knots());
    constexpr double kTolerance = 1e-9;
    if (std::abs(lasts - wanted) <= kTolerance * std::max(1.0, wanted)) return;
    out_.warning(file.file.place,
                 fmt::format("the solution '{}' lasts {:.9g} s, the problem {:.9g} s",
                             file.file.value, lasts, wanted),
                 lasts < wanted ? "its last state and control are held"
                                : "what comes later in it is not used");
  }

  /// True if a former solution has exactly the states (or controls) of this problem, and is thus of
  /// the same system. Augmented states follow from the other columns.
  bool fits(const DataFileSpec& file, const DataTable& table, bool states) {
    if (!table.state_columns) return true;
    const auto middle = table.columns.begin() + static_cast<std::ptrdiff_t>(*table.state_columns);
    const std::vector<std::string> found = states ? std::vector(table.columns.begin(), middle)
                                                  : std::vector(middle, table.columns.end());
    const std::vector<std::string> wanted = columns_of_problem(states);
    std::vector<std::string> known = wanted;
    for (const CostSpec& integral : spec_.integrals) known.push_back(integral.name.value);
    const std::vector<std::string> missing = without(wanted, found), extra = without(found, known);
    if (missing.empty() && extra.empty()) return true;
    out_.error(
        file.file.place,
        fmt::format("the {} of '{}' are not those of this problem:{}",
                    states ? "states" : "controls", file.file.value, difference(missing, extra)),
        "take a solution of the same system, or name 'columns' of the file in initial_guess");
    return false;
  }

  /// " it lacks a, and it has b".
  static std::string difference(const std::vector<std::string>& missing,
                                const std::vector<std::string>& extra) {
    std::string text;
    if (!missing.empty()) text += " it lacks " + listed(missing, kShownNames);
    if (!extra.empty())
      text +=
          fmt::format("{} it has {}", missing.empty() ? "" : ", and", listed(extra, kShownNames));
    return text;
  }

  /// Names that are not among others, without augmented states and slopes.
  static std::vector<std::string> without(const std::vector<std::string>& names,
                                          const std::vector<std::string>& others) {
    std::vector<std::string> rest;
    for (const std::string& name : names)
      if (!follows_from_others(name) &&
          std::find(others.begin(), others.end(), name) == others.end())
        rest.push_back(name);
    return rest;
  }
  static bool follows_from_others(const std::string& column) {
    return column.starts_with("previous/") || column.starts_with("start/") ||
           column.starts_with("slope_") || column.starts_with(kEndOfKnot);
  }

  /// Clamps controls to their bounds and reports where this was necessary.
  void keep_bounds(Trajectory& trajectory) {
    int knots = 0, control = -1;
    double worst = 0;
    const System* worst_system = nullptr;
    for (const int k : controlled_knots()) {
      const KnotModel& model = *problem_.knot(k).model;
      bool cut = false;
      for (int i = 0; i < problem_.nu(k); ++i) {
        const double asked = trajectory.u(k)[i];
        const double kept = std::clamp(asked, model.control_lower()[i], model.control_upper()[i]);
        trajectory.u(k)[i] = kept;
        if (kept == asked) continue;
        cut = true;
        if (!exceeds(std::abs(kept - asked), worst)) continue;
        worst = std::abs(kept - asked);
        worst_system = &model.system();
        control = i;
      }
      knots += cut;
    }
    if (knots == 0) return;
    const Column& column = worst_system->control_columns()[control];
    used_.controls += fmt::format(", clamped to their limits in {} knots", knots);
    out_.warning(guess().controls_place,
                 fmt::format("to hold the guessed states the controls would have to leave their "
                             "limits in {} of {} knots, '{}' by {:.4g} {}: they are clamped there",
                             knots, problem_.knots(), column.name, worst, column.unit));
  }

  /// Names of the states, or of the guessed controls.
  std::vector<std::string> columns_of_problem(bool states) const {
    if (states) return state_names(*plant_.system).names;
    if (plant_.variants.empty()) return control_names(guessed(*plant_.system)).names;
    return names_of_controls().names;
  }
  /// Names of all controls of the problem's systems.
  ComponentNames names_of_controls() const {
    std::vector<std::string> names;
    for (const Column& control : plant_.all_controls()) names.push_back(control.name);
    return {"controls", std::move(names)};
  }

  std::vector<std::string> file_columns(const DataFileSpec& file, bool states) {
    if (file.columns.empty()) return columns_of_problem(states);
    std::vector<std::string> wanted = columns_of_problem(states);
    if (is_partial(file, states)) return wanted;
    std::vector<std::string> columns;
    for (const Name& name : file.columns) columns.push_back(name.value);
    if (columns.size() == wanted.size()) return columns;
    out_.error(file.file.place,
               fmt::format("{} columns are needed, not {}", wanted.size(), columns.size()),
               fmt::format("or those of some {} by their names: {}", states ? "states" : "controls",
                           listed(wanted, kShownNames)));
    return {};
  }

  /// True if a file gives only some of the states or controls, identified by name.
  bool is_partial(const DataFileSpec& file, bool states) const {
    const std::vector<std::string> wanted = columns_of_problem(states);
    return !file.columns.empty() && file.columns.size() < wanted.size() &&
           std::ranges::all_of(file.columns, [&](const Name& name) {
             return std::ranges::find(wanted, name.value) != wanted.end();
           });
  }

  /// Table with the columns that a file gives. The other states are the initial ones, the other
  /// controls zero.
  DataTable with_others(const DataTable& table, const DataFileSpec& file, bool states) const {
    DataTable all{.file = table.file, .times = table.times};
    all.rows.resize(table.rows.size());
    const std::vector<std::string> wanted = columns_of_problem(states);
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      const bool given = std::ranges::any_of(
          file.columns, [&](const Name& name) { return name.value == wanted[i]; });
      const auto column = given ? table.find(wanted[i]) : std::nullopt;
      if (given && !column) continue;  // the later lookup reports it
      all.columns.push_back(wanted[i]);
      for (std::size_t row = 0; row < table.rows.size(); ++row)
        all.rows[row].push_back(column   ? table.rows[row][*column]
                                : states ? states_.initial()[i]
                                         : 0.0);
    }
    return all;
  }

  std::string describe(const DataFileSpec& file, const std::vector<TimeSeries>& series) const {
    std::string text = fmt::format("from {}", file.file.value);
    double last = 0;
    for (const TimeSeries& part : series) last = std::max(last, part.last_time());
    if (is_partial(file, &file == &*guess().states_file)) text += " as far as it names them";
    if (last + 1e-9 < time(problem_.knots() - 1))
      text += fmt::format(", its last values held after t = {} s", last);
    return text;
  }

  const ProblemSpec& spec_;
  const Plant& plant_;
  const StateBuilder& states_;
  const ShootingProblem& problem_;
  const ControlColumns columns_;
  GuessUsed& used_;
  Diagnostics& out_;
  std::map<std::filesystem::path, std::optional<DataTable>> tables_;
  std::vector<double> durations_;  ///< phases of a former solution, s
};

}  // namespace

std::optional<Trajectory> build_guess(const GuessContext& context, GuessUsed& used,
                                      Diagnostics& out) {
  return GuessBuilder(context, used, out).build();
}

}  // namespace conddp
