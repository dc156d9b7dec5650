#include "problem_file/build/build.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "analysis/comparison/random_instance.hpp"
#include "base/spelling.hpp"
#include "ocp/evaluation/evaluator.hpp"
#include "ocp/problem/by_name.hpp"
#include "ocp/problem/contradiction.hpp"
#include "problem_file/build/initial_choice.hpp"
#include "problem_file/build/memory_need.hpp"
#include "problem_file/data/dual_guess_reader.hpp"
#include "problem_file/plant/plant_builder.hpp"
#include "problem_file/plant/shape_pairs.hpp"
#include "problem_file/plant/stepping_builder.hpp"
#include "problem_file/spec/phase_grid.hpp"

namespace conddp {
namespace {

std::optional<Integrator> choose_integrator(const ProblemSpec& spec, const System& system,
                                            Diagnostics& out) {
  if (!spec.integrator) return default_integrator(system.kind());
  const Integrator integrator = spec.integrator->value;
  const auto fail = [&](const char* message, const char* hint) {
    out.error(spec.integrator->place, message, hint);
    return std::nullopt;
  };
  const bool discrete = system.kind() == SystemKind::discrete;
  if (discrete && integrator != Integrator::discrete)
    return fail("this system gives the next state itself: nothing is integrated",
                "write 'integrator: discrete' or leave the key out");
  if (!discrete && integrator == Integrator::discrete)
    return fail("this system is continuous: it needs an integrator",
                "accepted: semi_implicit_euler, explicit_euler, rk2, rk3, rk4, trapezoidal, "
                "hermite_simpson");
  if (integrator == Integrator::semi_implicit_euler && system.kind() != SystemKind::second_order)
    return fail("semi-implicit Euler needs positions and velocities, which this system has not",
                "accepted: explicit_euler, rk2, rk3, rk4, trapezoidal, hermite_simpson");
  return integrator;
}

/// When the nodes are, in s. Steps that vanish beside the time or lead beyond any are reported.
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
                fmt::format("steps of {:.3g} s vanish beside the time {:.3g} s", shortest, end));
    else
      continue;
    break;
  }
  return conddp::node_times(steps);
}

void check_solver(const ProblemSpec& spec, Diagnostics& out) {
  const SolverSpec& solver = spec.solver;
  if (solver.name.value == kAutoSolver) return;
  const SolverInfo* info = find_solver(solver.name.value);
  if (info == nullptr) {
    std::vector<std::string> names{std::string(kAutoSolver)};
    for (const SolverInfo& known : solvers()) names.emplace_back(known.name);
    return out.error(solver.name.place, fmt::format("unknown solver '{}'", solver.name.value),
                     name_hint(solver.name.value, names, "solvers"), names);
  }
  if (solver.options.hessian == HessianChoice::exact && !info->exact_hessian)
    out.error(solver.name.place, fmt::format("{} has no exact Hessian of the dynamics", info->name),
              "write 'hessian: automatic', or take ddp or box_ddp");
  if (solver.options.hessian == HessianChoice::gauss_newton && !info->gauss_newton_hessian)
    out.error(solver.name.place, fmt::format("{} always uses the exact Hessian", info->name),
              "write 'hessian: automatic', or take ilqr");
}

void check_drop(const ProblemSpec& spec, const std::vector<std::string>& drop, Diagnostics& out) {
  const std::vector<std::string> names = constraint_names(spec);
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
  for (const ControlBoundsSpec& constraint : spec.control_bounds) {
    auto own = build_control_bounds(constraint, spec, built.plant, out);
    if (!own) continue;
    if (std::find(options.drop.begin(), options.drop.end(), constraint.name.value) !=
        options.drop.end())
      built.dropped.push_back({constraint.name.value, std::move(*own), nullptr});
    else
      intersect(*own, constraint.name, built.plant, bounds, out);
  }
  return bounds;
}

/// Takes the constraints of these names out of a list.
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

/// A problem for each dropped constraint, so that its violation can be reported.
void keep_dropped(const PhaseContext& context, const std::vector<double>& start,
                  const std::vector<BuiltConstraint>& running,
                  const std::vector<BuiltConstraint>& terminal, BuiltProblem& built,
                  Diagnostics& out) {
  std::vector<std::string> names;
  for (const auto* list : {&running, &terminal})
    for (const BuiltConstraint& constraint : *list) {
      const std::string& name = constraint.spec->function.name.value;
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
  for (const std::string& name : names) {
    const auto only = [&](const std::vector<BuiltConstraint>& list) {
      std::vector<BuiltConstraint> chosen;
      for (const BuiltConstraint& constraint : list)
        if (constraint.spec->function.name.value == name) chosen.push_back(constraint);
      return chosen;
    };
    const std::vector<BuiltConstraint> knots = only(running), end = only(terminal);
    auto phases = build_phases(context, {{}, knots}, unbounded(context.spec, built.plant), out);
    if (phases.empty()) return;
    built.dropped.push_back(
        {name, std::nullopt,
         std::make_shared<ShootingProblem>(start, std::move(phases),
                                           build_terminal(context, {{}, knots}, {{}, end}, out))});
  }
}

void report_contradiction(const ProblemSpec& spec, const ShootingProblem& problem,
                          Diagnostics& out) {
  const auto found = find_contradiction(problem);
  if (!found) return;
  Place place;
  for (const auto* list : {&spec.constraints, &spec.terminal_constraints})
    for (const ConstraintSpec& constraint : *list)
      if (constraint.function.name.value == found->first) place = constraint.function.name.place;
  const std::string node =
      found->node == problem.knots() ? "the last node" : fmt::format("knot {}", found->node);
  const std::string other =
      found->second.empty() ? "the bounds on the control" : fmt::format("'{}'", found->second);
  out.error(place,
            fmt::format("'{}' and {} contradict each other at {}: nothing is at least {} and "
                        "at most {}",
                        found->first, other, node, found->lower, found->upper));
}

/// Controls that are remembered cannot pass an impulse.
void check_impulses(const ProblemSpec& spec, bool memory, Diagnostics& out) {
  for (const PhaseSpec& phase : spec.phases)
    if (memory && phase.restitution)
      out.error(phase.name.place,
                "an impulse interrupts the controls: 'control_rate' cannot pass it");
}

/// The control before the first knot, the last part of a state with control memory.
std::vector<double> previous_control(const ProblemSpec& spec, const Plant& plant, bool memory,
                                     Diagnostics& out) {
  const auto& given = spec.initial_state.previous_control;
  if (given && !memory) out.error(given->place, "'previous_control' serves 'control_rate' only");
  if (!given) return std::vector<double>(plant.actuated().nu(), 0.0);
  return resolve(*given, control_names(plant.actuated()), 0.0, out).value_or(std::vector<double>{});
}

void name_columns(bool memory, const InitialChoice* remembered, BuiltProblem& built) {
  built.state_columns = built.plant.system->state_columns();
  built.control_columns = built.plant.system->control_columns();
  if (remembered != nullptr)
    for (const Column& chosen : remembered->system->control_columns())
      built.state_columns.push_back({"start/" + chosen.name, chosen.unit});
  if (!memory) return;
  for (const Column& control : built.plant.actuated().control_columns())
    built.state_columns.push_back({"previous/" + control.name, control.unit});
}

}  // namespace

std::vector<std::string> constraint_names(const ProblemSpec& spec) {
  std::vector<std::string> names;
  const auto add = [&names](const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  };
  for (const ControlBoundsSpec& bounds : spec.control_bounds) add(bounds.name.value);
  for (const auto* list : {&spec.constraints, &spec.terminal_constraints})
    for (const ConstraintSpec& constraint : *list) add(constraint.function.name.value);
  return names;
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

std::optional<BuiltProblem> build_without_homotopy(const ProblemSpec& spec,
                                                   const BuildOptions& options, Diagnostics& out) {
  check_solver(spec, out);
  check_drop(spec, options.drop, out);
  auto plant = options.plant ? std::optional(*options.plant) : build_plant(spec, out);
  if (!plant) return std::nullopt;
  BuiltProblem built{.plant = std::move(*plant)};
  const System& system = *built.plant.system;
  const auto integrator = choose_integrator(spec, system, out);
  StateBuilder states(built.plant, out);
  const auto initial = states.build(spec.initial_state);
  if (initial) states.set_initial(*initial);
  const bool memory = spec.first_use(&ResidualNeeds::previous_control) != nullptr;
  const auto previous = previous_control(spec, built.plant, memory, out);
  if (!integrator || !initial) return std::nullopt;

  const auto start_choice = build_initial_choice(spec, built.plant, *initial, memory, out);
  if (!start_choice.valid) return std::nullopt;
  const InitialChoice* choice = start_choice.choice ? &*start_choice.choice : nullptr;
  if (choice == nullptr)
    states.check_limits("the initial state", *initial, [&](const std::string& joint) {
      const StateSpec& state = spec.initial_state;
      const auto said = std::find_if(state.joints.begin(), state.joints.end(),
                                     [&](const auto& s) { return s.first.value == joint; });
      return said == state.joints.end() ? state.place : said->first.place;
    });
  if (choice == nullptr && built.plant.stepping())
    warn_of_overlaps(spec, built.plant, *initial, out);
  if (choice != nullptr) built.plant.start = ChosenStart{choice->state, choice->coordinates};
  const int held = choice != nullptr && choice->remembered ? choice->system->nu() : 0;
  const int ndx = system.ndx() + (memory ? system.actuators() : held);
  const int errors = out.error_count();
  check_memory(spec, ndx, system.nu(), out);
  check_impulses(spec, memory, out);
  const std::vector<double> times = node_times(spec, out);
  if (out.error_count() > errors) return std::nullopt;  // what follows would fill the memory
  if (built.plant.multibody()) check_shapes(spec, built.plant, out);
  const auto contacts = ContactPlan::build(spec, built.plant, *initial, *integrator, out);
  if (!contacts || out.error_count() > errors) return std::nullopt;
  const CostContext context{spec, built.plant, *contacts, states, ndx, times};
  const std::vector<BuiltCost> costs = build_costs(spec.costs, context, out);
  const std::vector<BuiltCost> terminal_costs = build_costs(spec.terminal_costs, context, out);
  std::vector<BuiltConstraint> constraints = build_constraints(spec.constraints, context, out);
  std::vector<BuiltConstraint> at_end = build_constraints(spec.terminal_constraints, context, out);
  const std::vector<BuiltConstraint> dropped = take_dropped(options.drop, constraints);
  const std::vector<BuiltConstraint> dropped_at_end = take_dropped(options.drop, at_end);
  const PhaseBounds bounds = collect_bounds(spec, options, built, out);
  PhaseContext phase_context{spec,   *contacts, built.plant.system,     *integrator,
                             memory, times,     built.plant.stepping(), built.plant.collocation(),
                             choice};
  std::vector<Phase> phases = build_phases(phase_context, {costs, constraints}, bounds, out);
  if (out.has_errors()) return std::nullopt;
  Phase terminal =
      build_terminal(phase_context, {costs, constraints}, {terminal_costs, at_end}, out);
  if (out.has_errors()) return std::nullopt;

  std::vector<double> start = *initial;
  if (memory) start.insert(start.end(), previous.begin(), previous.end());
  start.resize(start.size() + held, 0.0);
  settle_initial_state(start, constraints, spec.solver.options.tolerances.constraint, phases, out);
  phase_context.stepping = nullptr;
  phase_context.collocation = nullptr;
  keep_dropped(phase_context, start, dropped, dropped_at_end, built, out);
  if (out.has_errors()) return std::nullopt;
  built.problem =
      std::make_shared<ShootingProblem>(std::move(start), std::move(phases), std::move(terminal));
  report_contradiction(spec, *built.problem, out);
  name_columns(memory, held > 0 ? choice : nullptr, built);
  auto guess = build_guess({spec, built.plant, states, *built.problem}, built.guess_used, out);
  if (!guess || out.has_errors()) return std::nullopt;
  built.guess = std::move(*guess);
  if (spec.perturbation.any()) {
    built.problem = std::make_shared<ShootingProblem>(perturb_initial_state(
        *built.problem, spec.perturbation.initial_state, spec.perturbation.seed));
    built.guess = guess_of_instance(*built.problem, built.guess, spec.perturbation);
  }
  if (spec.guess.multipliers_file) {
    const DataFileSpec& file = *spec.guess.multipliers_file;
    const auto duals = read_dual_guess(file.path, file.file.place, *built.problem, out);
    if (!duals) return std::nullopt;
    built.multipliers = duals->guess;
    built.guess_used.multipliers = duals->text;
  }
  built.data_files = out.data_files();
  return built;
}

namespace {

/// Where a file says what its solver refuses: at the solver's name, or, as it is not the file that
/// names it, at what is refused.
Place refused_place(const ProblemSpec& spec, bool of_control) {
  const Place& named = spec.solver.name.place;
  if (named.mark.source >= 0) return named;
  if (spec.stepping && spec.stepping->place.mark.source >= 0) return spec.stepping->place;
  if (spec.stepping && !spec.candidates.empty()) return spec.candidates.front().name.place;
  if (of_control && !spec.control_bounds.empty()) return spec.control_bounds.front().name.place;
  for (const auto* list : {&spec.constraints, &spec.terminal_constraints})
    if (!of_control && !list->empty()) return list->front().function.name.place;
  return named;
}

}  // namespace

std::vector<const SolverInfo*> usable_solvers(const ProblemSpec& spec,
                                              const ShootingProblem& problem, Diagnostics& out) {
  const SolverInfo* solver = find_solver(spec.solver.name.value);
  if (solver == nullptr) {
    std::vector<const SolverInfo*> list = auto_solvers(problem, spec.solver.options);
    if (!list.empty()) return list;
    // The reason is that of the first one that would take the problem with other options.
    list = auto_solvers(problem, {});
    solver = list.empty() ? find_solver("altro") : list.front();
  }
  const auto reason = unsupported(*solver, problem);
  if (!reason) {
    const auto too_many = unsupported_segments(*solver, problem, spec.solver.options.segments);
    if (!too_many) return {solver};
    const Place& named = spec.solver.name.place;
    out.error(named.mark.source >= 0 ? named : spec.solver.place, *too_many,
              "leave 'segments' out, or write a smaller number");
    return {};
  }
  const bool of_control = supports_constraints(*solver, problem);
  const Place place = refused_place(spec, of_control);
  if (spec.stepping) {
    out.error(place, *reason, "write 'solver: {name: ipopt}'");
    return {};
  }
  std::string names;
  for (const ControlBoundsSpec& bounds : spec.control_bounds)
    if (of_control) names += " --drop " + bounds.name.value;
  for (const auto* list : {&spec.constraints, &spec.terminal_constraints})
    for (const ConstraintSpec& constraint : *list)
      if (!of_control) names += " --drop " + constraint.function.name.value;
  out.error(place, *reason,
            names.empty()
                ? "choose one of them with --solver"
                : fmt::format("choose one of them with --solver, or leave the {} out with{}",
                              of_control ? "bounds" : "constraints", names));
  return {};
}

std::vector<std::string> tangent_columns(const BuiltProblem& built) {
  std::vector<std::string> names = tangent_names(*built.plant.system).names;
  for (int i = static_cast<int>(names.size()); i < built.problem->ndx(); ++i) {
    const std::size_t behind_states = built.state_columns.size() - built.problem->ndx() + i;
    names.push_back(built.state_columns[behind_states].name);
  }
  return names;
}

double violation(const DroppedConstraint& constraint, const ShootingProblem& problem,
                 const Trajectory& trajectory) {
  double largest = 0;
  if (constraint.alone) {
    Evaluation evaluation(*constraint.alone);
    Evaluator(*constraint.alone).evaluate(trajectory, evaluation);
    for (const auto& list : {violations_by_name(*constraint.alone, evaluation.constraint),
                             soft_violations(*constraint.alone, evaluation.constraint)})
      for (const ConstraintViolation& part : list) largest = std::max(largest, part.value);
    return largest;
  }
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
