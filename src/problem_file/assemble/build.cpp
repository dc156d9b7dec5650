#include "problem_file/assemble/build.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "analysis/comparison/random_instance.hpp"
#include "base/text/spelling.hpp"
#include "ocp/evaluation/evaluator.hpp"
#include "ocp/problem/by_name.hpp"
#include "ocp/problem/contradiction.hpp"
#include "problem_file/assemble/initial_choice.hpp"
#include "problem_file/assemble/linear_controls.hpp"
#include "problem_file/data/data_table.hpp"
#include "problem_file/data/dual_guess_reader.hpp"
#include "problem_file/mesh/mesh.hpp"
#include "problem_file/model/phase_grid.hpp"
#include "problem_file/motion/sampled_guess.hpp"
#include "problem_file/plant/collocation_builder.hpp"
#include "problem_file/plant/memory_need.hpp"
#include "problem_file/plant/plant_builder.hpp"
#include "problem_file/plant/shape_pairs.hpp"
#include "problem_file/plant/stepping_builder.hpp"
#include "problem_file/terms/drawing_builder.hpp"
#include "problem_file/terms/reach.hpp"
#include "systems/system.hpp"

namespace conddp {
namespace {

/// Largest time step of a robot without a warning, s.
constexpr double kLongestStep = 1;

/// "accepted: rk4, …": the integrators for systems with a rate, or also those with accelerations.
std::string accepted_integrators(bool second_order) {
  std::vector<std::string_view> names;
  for (const IntegratorInfo& info : kIntegrators)
    if (info.kind == StepKind::runge_kutta || info.kind == StepKind::collocation ||
        (second_order && info.kind == StepKind::semi_implicit))
      names.push_back(info.name);
  return fmt::format("accepted: {}", fmt::join(names, ", "));
}

std::optional<Integrator> choose_integrator(const ProblemSpec& spec, const System& system,
                                            Diagnostics& out) {
  if (!spec.integrator)
    return spec.has_linear_controls() ? Integrator::rk4 : default_integrator(system.kind());
  const Integrator integrator = spec.integrator->value;
  const auto fail = [&](const char* message, const std::string& hint) {
    out.error(spec.integrator->place, message, hint);
    return std::nullopt;
  };
  const bool discrete = system.kind() == SystemKind::discrete;
  if (discrete && integrator != Integrator::discrete)
    return fail("this system gives the next state itself: nothing is integrated",
                "write 'integrator: discrete' or leave the key out");
  if (!discrete && integrator == Integrator::discrete)
    return fail("this system is continuous: it needs an integrator", accepted_integrators(true));
  if (integrator == Integrator::semi_implicit_euler && system.kind() != SystemKind::second_order)
    return fail("semi-implicit Euler needs a system with positions and velocities",
                accepted_integrators(false));
  if (spec.has_linear_controls() && !follows_controls(integrator))
    return fail("linear controls need an integrator that accounts for their change during a step",
                "accepted: rk3, rk4, trapezoidal, hermite_simpson, radau3, radau5");
  return integrator;
}

/// Times of the nodes, s. Reports steps that vanish in rounding and motions that last too long.
std::vector<double> node_times(const ProblemSpec& spec, Diagnostics& out) {
  constexpr double kLongest = 1e9;
  std::vector<double> steps;
  double end = 0;
  for (const PhaseSpec& phase : spec.phases) {
    const std::vector<double> own = phase_steps(phase);
    steps.insert(steps.end(), own.begin(), own.end());
    double shortest = kLongest;
    for (const double step : own) {
      end += step;
      shortest = std::min(shortest, step);
    }
    if (end > kLongest)
      out.error(phase.knots.place, fmt::format("the motion lasts {:.3g} s up to the end of phase "
                                               "'{}', more than {:.0e} s",
                                               end, phase.name.value, kLongest));
    else if (!phase.takes_no_time() && !(end - shortest < end))
      out.error(phase.knots.place,
                fmt::format("steps of {:.3g} s are lost to rounding at the time {:.3g} s", shortest,
                            end));
    else
      continue;
    break;
  }
  return conddp::node_times(steps);
}

void report_unknown_solver(const Name& name, Diagnostics& out) {
  std::vector<std::string> names{std::string(kAutoSolver)};
  for (const SolverInfo& known : solvers()) names.emplace_back(known.name);
  out.error(name.place, fmt::format("unknown solver '{}'", name.value),
            name_hint(name.value, names, "solvers"), names);
}

void check_solver(const ProblemSpec& spec, Diagnostics& out) {
  const SolverSpec& solver = spec.solver;
  if (solver.name.value == kAutoSolver) return;
  const SolverInfo* info = find_solver(solver.name.value);
  if (info == nullptr) return report_unknown_solver(solver.name, out);
  if (solver.options.hessian == HessianChoice::exact && !info->exact_hessian)
    out.error(solver.name.place, fmt::format("{} has no exact Hessian of the dynamics", info->name),
              "write 'hessian: automatic', or take ddp or box_ddp");
  if (solver.options.hessian == HessianChoice::gauss_newton && !info->gauss_newton_hessian)
    out.error(solver.name.place, fmt::format("{} always uses the exact Hessian", info->name),
              "write 'hessian: automatic', or take ilqr");
}

std::vector<std::string> all_constraint_names(const ProblemSpec& spec) {
  std::vector<std::string> names;
  const auto add = [&names](const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  };
  for (const ConstraintSpec& bounds : spec.control_bounds) add(bounds.function.name.value);
  for (const ConstraintSpec* constraint : spec.all_constraints())
    add(constraint->function.name.value);
  return names;
}

void check_drop(const ProblemSpec& spec, const std::vector<std::string>& drop, Diagnostics& out) {
  const std::vector<std::string> names = all_constraint_names(spec);
  for (std::size_t i = 0; i < drop.size(); ++i)
    if (std::find(drop.begin(), drop.begin() + i, drop[i]) != drop.begin() + i)
      out.error({}, fmt::format("--drop {} stands twice on the command line", drop[i]));
  for (const std::string& name : drop)
    if (std::find(names.begin(), names.end(), name) == names.end())
      out.error({}, fmt::format("--drop {}: unknown constraint '{}'", name, name),
                name_hint(name, names, "constraints"), names);
}

/// Bounds of all constraints that are not dropped.
PhaseBounds collect_bounds(const ProblemSpec& spec, const BuildOptions& options,
                           BuiltProblem& built, Diagnostics& out) {
  PhaseBounds bounds = unbounded(spec, built.plant);
  for (const ConstraintSpec& constraint : spec.control_bounds) {
    auto own = build_control_bounds(constraint, spec, built.plant, out);
    if (!own) continue;
    if (std::find(options.drop.begin(), options.drop.end(), constraint.function.name.value) !=
        options.drop.end())
      built.dropped.push_back({constraint.function.name.value, std::move(*own), nullptr});
    else
      intersect(*own, constraint.function.name, built.plant, bounds, out);
  }
  return bounds;
}

/// Removes the constraints with these names from a list and returns them.
std::vector<BuiltConstraint> take_dropped(const std::vector<std::string>& drop,
                                          std::vector<BuiltConstraint>& constraints) {
  const auto is_dropped = [&](const BuiltConstraint& constraint) {
    return std::find(drop.begin(), drop.end(), constraint.spec->function.name.value) != drop.end();
  };
  const auto first = std::stable_partition(constraints.begin(), constraints.end(),
                                           [&](const auto& c) { return !is_dropped(c); });
  std::vector<BuiltConstraint> dropped(std::make_move_iterator(first),
                                       std::make_move_iterator(constraints.end()));
  constraints.erase(first, constraints.end());
  return dropped;
}

/// Names of constraints, without duplicates.
std::vector<std::string> names_of(const std::vector<BuiltConstraint>& running,
                                  const std::vector<BuiltConstraint>& terminal) {
  std::vector<std::string> names;
  for (const auto* list : {&running, &terminal})
    for (const BuiltConstraint& constraint : *list) {
      const std::string& name = constraint.spec->function.name.value;
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
  return names;
}

/// Builds a problem for each dropped constraint, so that its violation can be reported.
void keep_dropped(const PhaseContext& context, const std::vector<double>& start,
                  const std::vector<BuiltConstraint>& running,
                  const std::vector<BuiltConstraint>& terminal, BuiltProblem& built,
                  Diagnostics& out) {
  for (const std::string& name : names_of(running, terminal)) {
    const auto only = [&](const std::vector<BuiltConstraint>& list) {
      std::vector<BuiltConstraint> chosen;
      for (const BuiltConstraint& constraint : list)
        if (constraint.spec->function.name.value == name) chosen.push_back(constraint);
      return chosen;
    };
    const std::vector<BuiltConstraint> knots = only(running), end = only(terminal);
    auto phases = build_phases(context, {{}, knots, {}}, unbounded(context.spec, built.plant), out);
    if (phases.empty()) return;
    built.dropped.push_back(
        {name, std::nullopt,
         std::make_shared<ShootingProblem>(
             start, std::move(phases),
             build_terminal(context, {{}, knots, {}}, {{}, end, {}}, nullptr, out))});
  }
}

void report_contradiction(const ProblemSpec& spec, const ShootingProblem& problem,
                          Diagnostics& out) {
  const auto found = find_contradiction(problem);
  if (!found) return;
  Place place;
  bool has_previous = false;
  for (const ConstraintSpec* constraint : spec.all_constraints()) {
    const CostSpec& function = constraint->function;
    if (function.name.value == found->first) place = function.name.place;
    if (function.name.value == found->first || function.name.value == found->second)
      has_previous |=
          function.names_previous_control || function.definition->needs.previous_control;
  }
  const std::string node =
      found->node == problem.knots() ? "the last node" : fmt::format("knot {}", found->node);
  const std::string other =
      found->second.empty() ? "the bounds on the control" : fmt::format("'{}'", found->second);
  out.error(place,
            fmt::format("'{}' and {} contradict each other at {}: nothing is at least {} and "
                        "at most {}",
                        found->first, other, node, found->lower, found->upper),
            has_previous && found->node == 0
                ? "'previous_control' of the initial state (default: 0) is the control before it"
                : "");
}

/// Control before the first knot, or the first linear control, at the end of augmented states.
std::vector<double> previous_control(const ProblemSpec& spec, const Plant& plant,
                                     HeldControls controls, Diagnostics& out) {
  const auto& given = spec.initial_state.previous_control;
  if (given && controls == HeldControls::none)
    out.error(given->place,
              "'previous_control' serves 'control_rate', 'previous' and linear controls only");
  if (!given) return std::vector<double>(plant.actuated().nu(), 0.0);
  return resolve(*given, control_names(plant), 0.0, out).value_or(std::vector<double>{});
}

void name_columns(const ProblemSpec& spec, const StateTail& tail, BuiltProblem& built) {
  const std::vector<Column>& actuated = built.plant.actuated().control_columns();
  built.state_columns = built.plant.system->state_columns();
  std::ranges::move(tail.columns(spec.integrals, actuated),
                    std::back_inserter(built.state_columns));
  built.integrals = tail.integrals;
  built.control_columns = built.plant.variants.empty() ? built.plant.system->control_columns()
                                                       : ControlColumns(*built.problem).columns();
  for (std::size_t i = 0; tail.linear() && i < actuated.size(); ++i)
    built.control_columns[i].name = std::string(kEndOfKnot) + built.control_columns[i].name;
}

HeldControls held_controls(const ProblemSpec& spec) {
  if (spec.has_linear_controls()) return HeldControls::linear;
  return spec.first_use(&ResidualNeeds::previous_control) != nullptr ? HeldControls::previous
                                                                     : HeldControls::none;
}

/// Builds the problem of a plant step by step. A step returns false, after reporting the reason, if
/// the later steps cannot proceed.
class ProblemBuilder {
 public:
  ProblemBuilder(const std::shared_ptr<const ProblemSpec>& spec, const BuildOptions& options,
                 Plant plant, Diagnostics& out)
      : spec_(*spec),
        options_(options),
        out_(out),
        built_{.problem_spec = spec, .plant = std::move(plant)},
        states_(built_.plant, out),
        tail_{held_controls(spec_), built_.plant.actuated().nu(),
              static_cast<int>(spec_.integrals.size())} {}

  std::optional<BuiltProblem> build() {
    if (!set_start() || !set_nodes() || !set_problem() || !set_guess() || !set_multipliers())
      return std::nullopt;
    built_.data_files = out_.data_files();
    return std::move(built_);
  }

 private:
  /// Number of tangent coordinates of a node.
  int ndx() const { return built_.plant.system->ndx() + tail_.size(); }
  /// Number of tangent coordinates for residuals, which see linear controls at a knot's beginning
  /// as controls.
  int ndx_of_residuals() const { return ndx() - (tail_.linear() ? tail_.actuators : 0); }

  /// Reports a given first linear control that violates the bounds of the first node.
  void check_first_control(const PhaseBounds& bounds) {
    const auto& given = spec_.initial_state.previous_control;
    if (!tail_.linear() || !given) return;
    const std::vector<double>&lower = bounds.lower.back(), &upper = bounds.upper.back();
    for (std::size_t i = 0; i < previous_control_.size() && i < lower.size(); ++i)
      if (!(previous_control_[i] >= lower[i] && previous_control_[i] <= upper[i]))
        out_.error(given->place,
                   fmt::format("linear controls begin with {:g} here, and may be {:g} to {:g}",
                               previous_control_[i], lower[i], upper[i]));
  }

  /// Sets the integrator and the initial state, given or free.
  bool set_start() {
    const auto integrator = choose_integrator(spec_, *built_.plant.system, out_);
    const auto initial = states_.build(spec_.initial_state);
    if (initial) states_.set_initial(*initial);
    previous_control_ = previous_control(spec_, built_.plant, tail_.controls, out_);
    const bool fits = check_linear_controls(spec_, *built_.plant.system, out_);
    if (!integrator || !initial || !fits) return false;
    integrator_ = *integrator;
    auto start = build_initial_choice(spec_, built_.plant, *initial,
                                      tail_.controls == HeldControls::previous, out_);
    choice_ = std::move(start.choice);
    tail_.start = choice_ ? &*choice_ : nullptr;
    if (choice_)
      built_.plant.start = ChosenStart{choice_->state, choice_->coordinates, tail_.integrals};
    else if (start.valid)
      warn_of_initial_state();
    return start.valid;
  }

  /// Warns if a given initial state violates limits or penetrates surfaces.
  void warn_of_initial_state() const {
    const StateSpec& state = spec_.initial_state;
    states_.check_limits("the initial state", states_.initial(), [&](const std::string& joint) {
      const auto said = std::find_if(state.joints.begin(), state.joints.end(),
                                     [&](const auto& s) { return s.first.value == joint; });
      return said == state.joints.end() ? state.place : said->first.place;
    });
    if (built_.plant.stepping()) warn_of_overlaps(spec_, built_.plant, states_.initial(), out_);
  }

  /// Warns of a robot's time steps that are so long that milliseconds are likely meant.
  void warn_of_steps() const {
    if (!built_.plant.multibody() || built_.plant.collocation()) return;
    for (const PhaseSpec& phase : spec_.phases)
      if (!phase.takes_no_time() && phase.dt > kLongestStep)
        return out_.warning(
            phase.name.place,
            fmt::format("a time step of the phase '{}' lasts {:g} s", phase.name.value, phase.dt),
            "times are in s: 20 ms are 'dt: 0.02'");
  }

  /// Sets the times of the nodes and the contacts of each.
  bool set_nodes() {
    const int errors = out_.error_count();
    check_mesh(spec_, *built_.plant.system, out_);
    if (spec_.running_costs.value == RunningCosts::kIntegrated && info_of(integrator_).order == 0)
      out_.error(spec_.running_costs.place,
                 "steps that give the next state themselves have no intermediate states to "
                 "integrate costs over",
                 "write 'running_costs: rate'");
    check_memory(spec_, ndx(), built_.plant.system->nu(), out_);
    times_ = node_times(spec_, out_);
    if (out_.error_count() > errors) return false;  // later steps would exhaust the memory
    if (built_.plant.multibody()) check_shapes(spec_, built_.plant, out_);
    warn_of_steps();
    contacts_ = ContactPlan::build(spec_, built_.plant, states_.initial(), integrator_, out_);
    return contacts_ && out_.error_count() == errors;
  }

  /// Builds the integrals, whose names must be unique.
  std::vector<BuiltCost> build_integrals(const CostContext& context) const {
    std::vector<BuiltCost> integrals = build_costs(spec_.integrals, context, out_);
    for (const BuiltCost& integral : integrals)
      if (const int rows = integral.residual.residual->size(); rows != 1)
        out_.error(integral.spec->name.place,
                   fmt::format("an integral has one row, and '{}' has {}",
                               integral.spec->name.value, rows));
    for (const CostSpec& integral : spec_.integrals)
      if (is_taken(integral.name.value))
        out_.error(integral.name.place,
                   fmt::format("the name '{}' of an integral is taken", integral.name.value));
    return integrals;
  }

  bool is_taken(const std::string& name) const {
    const auto of_column = [&](const Column& column) {
      return column.name == name || column.name.starts_with(name + "/");
    };
    const auto of_parameter = [&](const auto& parameter) { return parameter.first == name; };
    return std::ranges::any_of(built_.plant.system->state_columns(), of_column) ||
           std::ranges::any_of(built_.plant.all_controls(), of_column) ||
           std::ranges::any_of(spec_.names.parameters, of_parameter);
  }

  /// System of the last node. Contacts cause forces there only if it has controls.
  std::shared_ptr<const System> system_at_the_end() const {
    const std::size_t end = contacts_->terminal();
    const bool forces = tail_.linear() && !contacts_->held(end).empty();
    return forces ? contacts_->system(end - 1) : built_.plant.at_last_node().system;
  }

  /// Initial value of the system's clock, s; 0 without a clock.
  double clock_start() const {
    const std::vector<Column>& columns = built_.plant.system->state_columns();
    for (std::size_t i = 0; i < columns.size(); ++i)
      if (columns[i].name == kClock && columns[i].by_name_only) return states_.initial()[i];
    return 0;
  }

  bool set_problem() {
    const Plant& plant = built_.plant;
    CostContext context{spec_, plant, *contacts_, states_, ndx_of_residuals(), times_};
    const std::vector<BuiltCost> costs = build_costs(spec_.costs, context, out_);
    const std::vector<BuiltCost> integrals = build_integrals(context);
    std::vector<BuiltConstraint> constraints = build_constraints(spec_.constraints, context, out_);
    context.last_node = true;
    const std::vector<BuiltCost> terminal_costs = build_costs(spec_.terminal_costs, context, out_);
    std::vector<BuiltConstraint> at_end =
        build_constraints(spec_.terminal_constraints, context, out_);
    warn_of_reach(costs, constraints, plant, out_);
    warn_of_reach(terminal_costs, at_end, plant, out_);
    const std::vector<BuiltConstraint> dropped = take_dropped(options_.drop, constraints);
    const std::vector<BuiltConstraint> dropped_at_end = take_dropped(options_.drop, at_end);
    const PhaseBounds bounds = collect_bounds(spec_, options_, built_, out_);
    check_first_control(bounds);
    const std::vector<NodeTime> nodes = conddp::node_times(spec_, times_, clock_start());
    PhaseContext phase_context{spec_,       plant, *contacts_,       system_at_the_end(),
                               integrator_, nodes, plant.stepping(), plant.collocation() != nullptr,
                               tail_};
    std::vector<Phase> phases =
        build_phases(phase_context, {costs, constraints, integrals}, bounds, out_);
    if (out_.has_errors()) return false;
    if (spec_.terminal_lqr)
      built_.terminal_lqr = build_terminal_lqr(
          {spec_, plant, states_, phases,
           tail_.columns(spec_.integrals, plant.actuated().control_columns()), tail_.written()},
          out_);
    Phase terminal = build_terminal(phase_context, {costs, constraints, {}},
                                    {terminal_costs, at_end, {}}, built_.terminal_lqr.get(), out_);
    if (out_.has_errors()) return false;

    std::vector<double> start = initial_state();
    settle_initial_state(start, constraints, spec_.solver.options.tolerances.constraint, phases,
                         out_);
    phase_context.stepping = nullptr;
    phase_context.collocates = false;
    keep_dropped(phase_context, start, dropped, dropped_at_end, built_, out_);
    if (out_.has_errors()) return false;
    set_drawn(phase_context, start);
    if (out_.has_errors()) return false;
    built_.problem =
        std::make_shared<ShootingProblem>(std::move(start), std::move(phases), std::move(terminal));
    report_contradiction(spec_, *built_.problem, out_);
    name_columns(spec_, tail_, built_);
    return true;
  }

  /// Builds the problem of the drawings, if the file has any.
  void set_drawn(const PhaseContext& context, const std::vector<double>& start) {
    if (spec_.drawings.empty()) return;
    const std::vector<ConstraintSpec> texts = drawn_constraints(spec_.drawings);
    const std::vector<BuiltConstraint> drawn = build_drawn(
        texts, {spec_, built_.plant, *contacts_, states_, ndx_of_residuals(), times_}, out_);
    auto phases = build_phases(context, {{}, drawn, {}}, unbounded(spec_, built_.plant), out_);
    if (out_.has_errors()) return;
    built_.drawn = std::make_shared<ShootingProblem>(
        start, std::move(phases),
        build_terminal(context, {{}, drawn, {}}, {{}, {}, {}}, nullptr, out_));
  }

  /// State of the first node, including its augmented part.
  std::vector<double> initial_state() const {
    std::vector<double> x = states_.initial();
    x.resize(x.size() + tail_.held(), 0.0);
    if (tail_.controls != HeldControls::none)
      x.insert(x.end(), previous_control_.begin(), previous_control_.end());
    return x;
  }

  /// Sets the initial guess, and the random instance derived from it if the file has one.
  bool set_guess() {
    const GuessContext context{spec_, built_.plant, states_, *built_.problem};
    auto guess = build_guess(context, built_.guess_used, out_);
    if (!guess || out_.has_errors()) return false;
    built_.guess = std::move(*guess);
    if (spec_.guess.sampling && !sample()) return false;
    if (!spec_.perturbation.any() || options_.unperturbed) return true;
    built_.problem = std::make_shared<ShootingProblem>(perturb_initial_state(
        *built_.problem, spec_.perturbation.initial_state, spec_.perturbation.seed));
    built_.guess = guess_of_instance(*built_.problem, built_.guess, spec_.perturbation);
    return true;
  }

  /// Samples around the guess. Steps of collocation rules are equations; rollouts take explicit
  /// steps by rk4 instead.
  bool sample() {
    GuessUsed& used = built_.guess_used;
    used.seed = spec_.guess.sampling->seed;
    if (!built_.plant.collocation())
      return sample_guess(spec_, built_.plant, *built_.problem, built_.guess, used.states,
                          used.controls, out_);
    ProblemSpec spec = spec_;
    spec.integrator = Located<Integrator>{Integrator::rk4, spec_.integrator->place};
    BuildOptions options{.drop = options_.drop, .unperturbed = true};
    const auto built = build_without_homotopy(std::move(spec), options, out_);
    if (!built) return false;
    for (int k = 0; k <= built_.problem->knots(); ++k) {
      built_.guess.x(k) = built->guess.x(k);
      if (k < built_.problem->knots())
        built_.guess.u(k).head(built->guess.nu(k)) = built->guess.u(k);
    }
    guess_slopes(*built_.problem, built_.guess);
    used = built->guess_used;
    return true;
  }

  bool set_multipliers() {
    if (!spec_.guess.multipliers_file) return true;
    const DataFileSpec& file = *spec_.guess.multipliers_file;
    const auto duals = read_dual_guess(file.path, file.file.place, *built_.problem, out_);
    if (!duals) return false;
    built_.multipliers = duals->guess;
    built_.guess_used.multipliers = duals->text;
    return true;
  }

  const ProblemSpec& spec_;
  const BuildOptions& options_;
  Diagnostics& out_;
  BuiltProblem built_;
  StateBuilder states_;
  StateTail tail_;
  Integrator integrator_{};
  std::vector<double> previous_control_;
  std::optional<InitialChoice> choice_;
  std::vector<double> times_;  ///< of the nodes, s
  std::optional<ContactPlan> contacts_;
};

}  // namespace

std::vector<std::string> constraint_names(const BuiltProblem& built) {
  return all_constraint_names(*built.problem_spec);
}

Integrator default_integrator(SystemKind kind) {
  switch (kind) {
    case SystemKind::discrete:
      return Integrator::discrete;
    case SystemKind::first_order:
      return Integrator::rk4;
    case SystemKind::impulse:
      return Integrator::impulse;
    case SystemKind::second_order:
      break;
  }
  return Integrator::semi_implicit_euler;
}

std::optional<BuiltProblem> build_without_homotopy(ProblemSpec spec, const BuildOptions& options,
                                                   Diagnostics& out) {
  check_solver(spec, out);
  check_drop(spec, options.drop, out);
  auto plant = options.plant ? std::optional(*options.plant) : build_plant(spec, out);
  if (!plant) return std::nullopt;
  const auto kept = std::make_shared<const ProblemSpec>(std::move(spec));
  return ProblemBuilder(kept, options, *std::move(plant), out).build();
}

namespace {

bool is_written(const Place& place) { return place.mark.source >= 0; }

bool has_terminal_set(const ProblemSpec& spec) {
  return spec.terminal_lqr && spec.terminal_lqr->set;
}

/// Place of the first bounds on the control, or of the first constraint with one of the names;
/// falls back to the solver's place.
Place first_constraint(const ProblemSpec& spec, const std::vector<std::string>& names) {
  if (names.empty() && !spec.control_bounds.empty())
    return spec.control_bounds.front().function.name.place;
  for (const std::string& name : names)
    for (const ConstraintSpec* constraint : spec.all_constraints())
      if (constraint->function.name.value == name) return constraint->function.name.place;
  if (!names.empty() && has_terminal_set(spec)) return spec.terminal_lqr->set_place;
  return spec.solver.name.place;
}

/// Place for reporting an unsupported feature: the solver's name, or the feature itself if the file
/// does not name the solver.
Place unsupported_place(const ProblemSpec& spec, const std::vector<std::string>& names) {
  if (is_written(spec.solver.name.place)) return spec.solver.name.place;
  if (spec.stepping && is_written(spec.stepping->place)) return spec.stepping->place;
  if (spec.stepping && !spec.candidates.empty()) return spec.candidates.front().name.place;
  return first_constraint(spec, names);
}

/// Command-line options that drop the constraints with these names or, if `names` is empty, all
/// bounds on the control.
std::string drop_options(const ProblemSpec& spec, const std::vector<std::string>& names) {
  std::string options;
  if (names.empty()) {
    for (const ConstraintSpec& bounds : spec.control_bounds)
      options += " --drop " + bounds.function.name.value;
    return options;
  }
  for (const ConstraintSpec* constraint : spec.all_constraints())
    if (std::ranges::find(names, constraint->function.name.value) != names.end())
      options += " --drop " + constraint->function.name.value;
  if (has_terminal_set(spec)) options += " --set terminal.lqr.set=false";
  return options;
}

/// `names` lists the unsupported constraints; empty if bounds on the control are unsupported.
void report_unsupported(const ProblemSpec& spec, const std::string& reason,
                        const std::vector<std::string>& names, Diagnostics& out) {
  const Place place = unsupported_place(spec, names);
  if (spec.stepping) return out.error(place, reason, "write 'solver: {name: auto}'");
  const std::string options = drop_options(spec, names);
  out.error(place, reason,
            options.empty()
                ? "choose one of them with --solver"
                : fmt::format("choose one of them with --solver, or leave the {} out with{}",
                              names.empty() ? "bounds" : "constraints", options));
}

/// Solver to report if `auto` finds none: the first that would support the problem with other
/// options.
const SolverInfo& nearest_solver(const ShootingProblem& problem) {
  const std::vector<const SolverInfo*> list = auto_solvers(problem, {});
  return list.empty() ? *find_solver("altro") : *list.front();
}

/// The solver, if it supports the problem; else empty, with a report.
std::vector<const SolverInfo*> supporting(const SolverInfo& solver, const ProblemSpec& spec,
                                          const ShootingProblem& problem, Diagnostics& out) {
  if (const auto reason = unsupported(solver, problem)) {
    report_unsupported(spec, *reason, unsupported_constraints(solver, problem), out);
    return {};
  }
  return {&solver};
}

}  // namespace

std::vector<const SolverInfo*> usable_solvers(const BuiltProblem& built, Diagnostics& out) {
  const ProblemSpec& spec = *built.problem_spec;
  const ShootingProblem& problem = *built.problem;
  if (const SolverInfo* solver = find_solver(spec.solver.name.value))
    return supporting(*solver, spec, problem, out);
  const std::vector<const SolverInfo*> list = auto_solvers(problem, spec.solver.options);
  return list.empty() ? supporting(nearest_solver(problem), spec, problem, out) : list;
}

std::vector<std::string> tangent_columns(const BuiltProblem& built) {
  std::vector<std::string> names = tangent_names(*built.plant.system).names;
  for (int i = static_cast<int>(names.size()); i < built.problem->ndx(); ++i) {
    const std::size_t behind_states = built.state_columns.size() - built.problem->ndx() + i;
    names.push_back(built.state_columns[behind_states].name);
  }
  return names;
}

namespace {

/// Largest violation of a problem's constraints, including soft ones.
double largest_violation(const ShootingProblem& problem, const Trajectory& trajectory) {
  double largest = 0;
  Evaluation evaluation(problem);
  Evaluator(problem).evaluate(trajectory, evaluation);
  for (const auto& list : {violations_by_name(problem, evaluation.constraint),
                           soft_violations(problem, trajectory, evaluation.constraint)})
    for (const ConstraintViolation& part : list) largest = std::max(largest, part.value);
  return largest;
}

}  // namespace

double violation(const DroppedConstraint& constraint, const ShootingProblem& problem,
                 const Trajectory& trajectory) {
  if (constraint.alone) return largest_violation(*constraint.alone, trajectory);
  double largest = 0;
  for (int k = 0; k < problem.knots(); ++k) {
    const std::size_t phase = problem.knot(k).phase;
    if (problem.phases()[phase].instant) continue;
    for (int i = 0; i < trajectory.nu(k); ++i) {
      largest = std::max(largest, constraint.bounds->lower[phase][i] - trajectory.u(k)[i]);
      largest = std::max(largest, trajectory.u(k)[i] - constraint.bounds->upper[phase][i]);
    }
  }
  return largest;
}

}  // namespace conddp
