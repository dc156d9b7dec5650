#include "problem_file/build/phase_builder.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "problem_file/plant/collocation_builder.hpp"
#include "problem_file/plant/stepping_builder.hpp"
#include "problem_file/spec/named_phases.hpp"
#include "problem_file/spec/phase_grid.hpp"

namespace conddp {
namespace {

/// Some residuals need a control whatever they are on, others by what they combine.
bool needs_control(const BuiltCost& cost) {
  return cost.spec->definition->needs.control || cost.residual.residual->needs_control();
}

/// The phases in which a cost is on. Costs on a contact are on while it is held, and impulses have
/// only the costs that name them.
std::vector<bool> phases_of(const BuiltCost& cost, const PhaseContext& context, Diagnostics& out) {
  const CostSpec& c = *cost.spec;
  std::vector<bool> in_phase = phases_named(c.phases, context.spec, out);
  for (std::size_t p = 0; p < in_phase.size(); ++p) {
    const PhaseSpec& phase = context.spec.phases[p];
    if (cost.contact.contact >= 0 && !context.contacts.find(p, cost.contact.contact))
      in_phase[p] = false;
    if (!phase.takes_no_time() || !in_phase[p]) continue;
    if (phase.choice && c.phases) {
      out.error(c.name.place,
                fmt::format("'{}' is not a place for costs and constraints: it chooses "
                            "the state of the knot after it",
                            phase.name.value));
      in_phase[p] = false;
    } else if (!c.phases)
      in_phase[p] = false;
    else if (needs_control(cost))
      out.error(c.residual.place,
                fmt::format("the residual '{}' needs a control, and the impulse '{}' has none",
                            c.residual.value, phase.name.value));
  }
  return in_phase;
}

/// What running costs of a phase are multiplied by, knot by knot.
std::vector<double> cost_scales(const PhaseSpec& phase, const ProblemSpec& spec) {
  const bool rate = spec.running_costs == RunningCosts::kRate && !phase.takes_no_time();
  return rate ? phase_steps(phase) : std::vector<double>(phase.knots.value, 1.0);
}

/// A swing's last node is the first one after its phases. A touch-down is a moment: its cost is not
/// multiplied by the time step, as it is not at an impulse or at the last node.
void extend_to_touch_down(const ProblemSpec& spec, std::vector<double>& weights) {
  std::size_t first = weights.size();
  for (std::size_t p = spec.phases.size(); p-- > 0;) {
    first -= spec.phases[p].knots.value;
    if (first > 0 && weights[first] == 0)
      weights[first] = weights[first - 1] / cost_scales(spec.phases[p], spec).front();
  }
}

/// A cost's weight at each running knot, 0 where it is off; of a constraint 1 where it is on.
std::vector<double> schedule(const PhaseContext& context, const BuiltCost& cost, bool weighted,
                             Diagnostics& out) {
  const ProblemSpec& spec = context.spec;
  const CostSpec& c = *cost.spec;
  const std::vector<bool> in_phase = phases_of(cost, context, out);
  std::vector<double> row;
  for (std::size_t p = 0; p < spec.phases.size(); ++p) {
    double weight = c.weight;
    if (weighted)
      for (const auto& [name, value] : spec.phases[p].weights)
        if (name.value == c.name.value) weight = value;
    row.insert(row.end(), spec.phases[p].knots.value, in_phase[p] ? weight : 0.0);
  }
  if (c.keys.find(key::swing) != nullptr) extend_to_touch_down(spec, row);
  if (!c.knots) return row;
  std::vector<bool> chosen(row.size(), false);
  for (const Located<int>& knot : *c.knots) {
    if (knot.value < static_cast<int>(row.size()))
      chosen[knot.value] = true;
    else
      out.error(knot.place, fmt::format("running knots are numbered from 0 to {}", row.size() - 1),
                weighted ? "costs on the last node stand under 'terminal'"
                         : "constraints on the last node stand under 'terminal'");
  }
  for (std::size_t k = 0; k < row.size(); ++k)
    if (!chosen[k]) row[k] = 0;
  return row;
}

/// Those that are on somewhere in a run of knots.
std::vector<int> active_in(const std::vector<std::vector<double>>& weights, int first, int count) {
  std::vector<int> active;
  for (std::size_t c = 0; c < weights.size(); ++c) {
    const auto begin = weights[c].begin() + first;
    if (std::any_of(begin, begin + count, [](double w) { return w != 0; }))
      active.push_back(static_cast<int>(c));
  }
  return active;
}

/// Whether a swing ends at the last node: it lasts until then, and the node holds the foot.
bool touches_down_at_the_end(const BuiltCost& cost, const PhaseContext& context, Diagnostics& out) {
  if (cost.spec->keys.find(key::swing) == nullptr || !phases_of(cost, context, out).back())
    return false;
  const auto& contacts = context.contacts.contacts();
  for (std::size_t c = 0; c < contacts.size(); ++c)
    if (contacts[c].frame == cost.residual.frame &&
        context.contacts.find(context.contacts.terminal(), static_cast<int>(c)))
      return true;
  return false;
}

/// A cost's residual in the system of a phase, or at the last node.
std::shared_ptr<const Residual> residual_in(const BuiltCost& cost, const PhaseContext& context,
                                            std::size_t phase) {
  if (cost.contact.contact < 0) return cost.residual.residual;
  if (phase == context.contacts.terminal())
    return cost.contact.make(std::static_pointer_cast<const MultibodySystem>(context.system), 0);
  return cost.contact.make(
      std::static_pointer_cast<const MultibodySystem>(context.contacts.system(phase)),
      *context.contacts.find(phase, cost.contact.contact));
}

/// The knot that chooses the initial state.
Phase choice_phase(const PhaseSpec& given, const InitialChoice& choice) {
  auto model =
      std::make_shared<KnotModel>(choice.system, Integrator::explicit_euler, choice.remembered);
  model->set_control_bounds(choice.lower, choice.upper);
  return {.name = given.name.value,
          .model = std::move(model),
          .dt = {1.0},
          .cost_scale = {1.0},
          .parameters = {},
          .instant = true};
}

/// Says which controls have no bound although the URDF is to give it.
void warn_of_unbounded(const ControlBoundsSpec& constraint, const std::vector<std::string>& names,
                       const std::vector<double>& lower, const std::vector<double>& upper,
                       Diagnostics& out) {
  std::vector<std::string> without;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (std::isinf(lower[i]) && std::isinf(upper[i])) without.push_back("'" + names[i] + "'");
  if (without.empty()) return;
  if (without.size() == names.size())
    return out.warning(constraint.from_place, "the URDF gives no effort limit to any control");
  out.warning(constraint.from_place,
              fmt::format("the URDF gives no effort limit to {}", fmt::join(without, ", ")),
              "without 'lower' and 'upper' for it a control stays unbounded");
}

}  // namespace

PhaseBounds unbounded(const ProblemSpec& spec, const Plant& plant) {
  const std::vector<double> none(plant.system->nu(), kUnlimited);
  std::vector<double> below(none.size(), -kUnlimited);
  return {std::vector(spec.phases.size(), below), std::vector(spec.phases.size(), none)};
}

std::optional<PhaseBounds> build_control_bounds(const ControlBoundsSpec& constraint,
                                                const ProblemSpec& spec, const Plant& plant,
                                                Diagnostics& out) {
  const ComponentNames names = control_names(plant.actuated());
  const int errors = out.error_count();
  std::vector<double> lower(names.names.size(), -kUnlimited), upper(names.names.size(), kUnlimited);
  if (constraint.from_urdf) {
    lower = plant.actuated().control_lower();
    upper = plant.actuated().control_upper();
    scale_efforts(constraint.scale, lower, upper);
    if (!plant.multibody())
      out.error(constraint.from_place, "a closed-form system has no URDF",
                "give 'lower' and 'upper'");
  }
  const auto narrow = [&](const std::optional<ComponentsSpec>& given, std::vector<double>& bounds,
                          double none, auto better) {
    if (!given) return;
    if (const auto values = resolve(*given, names, none, out))
      for (std::size_t i = 0; i < bounds.size(); ++i) bounds[i] = better(bounds[i], (*values)[i]);
  };
  narrow(constraint.lower, lower, -kUnlimited, [](double a, double b) { return std::max(a, b); });
  narrow(constraint.upper, upper, kUnlimited, [](double a, double b) { return std::min(a, b); });
  const std::vector<bool> named = phases_named(constraint.phases, spec, out);
  if (out.error_count() > errors) return std::nullopt;
  if (constraint.from_urdf) warn_of_unbounded(constraint, names.names, lower, upper, out);
  PhaseBounds bounds = unbounded(spec, plant);
  for (std::size_t p = 0; p < named.size(); ++p) {
    if (!named[p]) continue;
    std::copy(lower.begin(), lower.end(), bounds.lower[p].begin());
    std::copy(upper.begin(), upper.end(), bounds.upper[p].begin());
  }
  return bounds;
}

void intersect(const PhaseBounds& other, const Name& name, const Plant& plant, PhaseBounds& bounds,
               Diagnostics& out) {
  for (std::size_t p = 0; p < bounds.lower.size(); ++p)
    for (std::size_t i = 0; i < bounds.lower[p].size(); ++i) {
      double& lower = bounds.lower[p][i];
      double& upper = bounds.upper[p][i];
      lower = std::max(lower, other.lower[p][i]);
      upper = std::min(upper, other.upper[p][i]);
      if (lower <= upper) continue;
      return out.error(
          name.place, fmt::format("no value of '{}' satisfies the bounds: the lower one is {}, the "
                                  "upper one {}",
                                  plant.system->control_columns()[i].name, lower, upper));
    }
}

std::vector<Phase> build_phases(const PhaseContext& context, const KnotContents& contents,
                                const PhaseBounds& bounds, Diagnostics& out) {
  const ProblemSpec& spec = context.spec;
  const auto& [costs, constraints] = contents;
  check_phases(spec, out);
  std::vector<std::vector<double>> weights, switches;
  for (const BuiltCost& cost : costs) weights.push_back(schedule(context, cost, true, out));
  for (const BuiltConstraint& constraint : constraints)
    switches.push_back(schedule(context, constraint.function, false, out));
  if (out.has_errors()) return {};
  using Structure = std::tuple<std::vector<int>, std::vector<int>, std::vector<double>,
                               std::vector<double>, const System*, int>;
  std::map<Structure, std::shared_ptr<const KnotModel>> models;
  std::vector<Phase> phases;
  int first = 0;
  for (std::size_t p = 0; p < spec.phases.size(); ++p) {
    const PhaseSpec& given = spec.phases[p];
    const int n = given.knots.value;
    if (given.choice) {
      phases.push_back(choice_phase(given, *context.start));
      first += n;
      continue;
    }
    const std::vector<int> active = active_in(weights, first, n);
    const std::vector<int> kept = active_in(switches, first, n);
    const auto& system = context.contacts.system(p);
    const std::optional<FreeDuration> duration = context.free_duration(p);
    auto& model = models[{active, kept, bounds.lower[p], bounds.upper[p], system.get(),
                          duration ? duration->memory : -1}];
    if (!model) {
      const bool impulse = given.restitution.has_value();
      auto fresh =
          std::make_shared<KnotModel>(system, impulse ? Integrator::impulse : context.integrator,
                                      context.control_memory, context.held_memory());
      for (const int c : active)
        fresh->add_cost(costs[c].spec->name.value, residual_in(costs[c], context, p),
                        costs[c].activation);
      for (const int c : kept)
        fresh->add_constraint(
            make_term(constraints[c], residual_in(constraints[c].function, context, p)));
      if (context.stepping) add_stepping_terms(context.stepping, *fresh);
      if (!impulse) fresh->set_control_bounds(bounds.lower[p], bounds.upper[p]);
      if (duration) fresh->set_free_duration(*duration);
      if (context.collocation) add_collocation_terms(context.collocation, *fresh);
      model = std::move(fresh);
    }
    Phase phase{.name = given.name.value, .model = model};
    phase.dt = phase_steps(given);
    phase.cost_scale = cost_scales(given, spec);
    phase.parameters.resize(static_cast<std::size_t>(n) * model->parameter_count());
    for (int k = 0; k < n; ++k) {
      double* parameters = phase.parameters.data() + k * model->parameter_count();
      const double time = context.times[first + k];
      for (std::size_t i = 0; i < active.size(); ++i)
        write_parameters(costs[active[i]], model->costs()[i], time, weights[active[i]][first + k],
                         parameters);
      for (std::size_t i = 0; i < kept.size(); ++i)
        write_parameters(constraints[kept[i]], model->constraints()[i], time,
                         switches[kept[i]][first + k] != 0, parameters);
      if (context.stepping)
        write_stepping_parameters(*model, phase.dt[k], spec.stepping->regularization, parameters);
      if (context.collocation) write_collocation_parameters(*model, phase.dt[k], parameters);
    }
    phases.push_back(std::move(phase));
    first += n;
  }
  return phases;
}

Phase build_terminal(const PhaseContext& context, const KnotContents& running,
                     const KnotContents& terminal, Diagnostics& out) {
  auto model = std::make_shared<KnotModel>(context.system, Integrator::none, context.control_memory,
                                           context.held_memory());
  const std::size_t node = context.contacts.terminal();
  const auto is_without_control = [&](const BuiltCost& function) {
    if (function.contact.contact >= 0 || !function.residual.residual->needs_control()) return true;
    out.error(function.spec->residual.place,
              "this residual needs a control, and there is none at the terminal node");
    return false;
  };
  // Whether the node holds the contact of a residual; one that is named and not held is an error.
  const auto is_held = [&](const BuiltCost& function) {
    const int contact = function.contact.contact;
    if (contact < 0 || context.contacts.find(node, contact)) return true;
    const bool none = context.contacts.held(node).empty();
    if (none || !function.spec->keys.value(key::contacts).all)
      out.error(function.spec->residual.place,
                none ? "the last node holds no contact"
                     : fmt::format("the last node does not hold the contact '{}'",
                                   context.spec.contacts[contact].name.value),
                "write 'terminal: {contacts: [...]}'");
    return false;
  };
  std::vector<const BuiltCost*> costs;
  for (const BuiltCost& cost : terminal.costs)
    if (is_held(cost) && is_without_control(cost)) costs.push_back(&cost);
  for (const BuiltCost& cost : running.costs)
    if (touches_down_at_the_end(cost, context, out)) costs.push_back(&cost);
  std::vector<const BuiltConstraint*> constraints;
  for (const BuiltConstraint& constraint : terminal.constraints)
    if (is_held(constraint.function) && is_without_control(constraint.function))
      constraints.push_back(&constraint);
  for (const BuiltConstraint& constraint : running.constraints)
    if (constraint.at_last_node) constraints.push_back(&constraint);

  for (const BuiltCost* cost : costs)
    model->add_cost(cost->spec->name.value, residual_in(*cost, context, node), cost->activation);
  for (const BuiltConstraint* constraint : constraints)
    model->add_constraint(make_term(*constraint, residual_in(constraint->function, context, node)));
  Phase phase{.name = "terminal", .dt = {0.0}, .cost_scale = {1.0}};
  phase.parameters.resize(model->parameter_count());
  for (std::size_t i = 0; i < costs.size(); ++i)
    write_parameters(*costs[i], model->costs()[i], context.times.back(), costs[i]->spec->weight,
                     phase.parameters.data());
  for (std::size_t i = 0; i < constraints.size(); ++i)
    write_parameters(*constraints[i], model->constraints()[i], context.times.back(), true,
                     phase.parameters.data());
  phase.model = std::move(model);
  return phase;
}

void settle_initial_state(const std::vector<double>& initial_state,
                          const std::vector<BuiltConstraint>& constraints, double tolerance,
                          std::vector<Phase>& phases, Diagnostics& out) {
  Phase& phase = phases.front();
  const KnotModel& model = *phase.model;
  if (model.constraints().empty()) return;
  const std::vector<double> u(model.nu(), 0.0);
  KnotWorkspace<double> work(model);
  model.evaluate(KnotInput<double>{initial_state.data(), u.data(), phase.parameters.data(),
                                   phase.dt[0], phase.cost_scale[0]},
                 work);
  for (const ConstraintTerm& term : model.constraints()) {
    double& active = phase.parameters[term.active()];
    if (active == 0 || term.depends_on_control(model.ndx())) continue;
    active = 0;
    if (term.softness != Softness::hard) continue;
    const double* lower = phase.parameters.data() + term.lower();
    const double violation =
        distance_to_set(term, work.constraint.data() + term.row, lower, lower + term.rows);
    if (violation <= tolerance) continue;
    for (const BuiltConstraint& constraint : constraints)
      if (constraint.spec->function.name.value == term.name) {
        out.error(constraint.spec->function.name.place,
                  fmt::format("the initial state violates the constraint '{}' by {:.3g}", term.name,
                              violation),
                  "no control can change that: move the initial state, or leave knot 0 out");
        break;
      }
  }
}

}  // namespace conddp
