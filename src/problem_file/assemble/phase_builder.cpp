#include "problem_file/assemble/phase_builder.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/exceeds.hpp"
#include "problem_file/assemble/linear_controls.hpp"
#include "problem_file/model/named_phases.hpp"
#include "problem_file/model/phase_grid.hpp"
#include "problem_file/plant/collocation_builder.hpp"
#include "problem_file/plant/stepping_builder.hpp"

namespace conddp {
namespace {

/// True if a cost needs a control, due to its kind or to the terms that it combines.
bool needs_control(const BuiltCost& cost) {
  return cost.spec->definition->needs.control || cost.residual.residual->needs_control();
}

/// True if a cost can be active in a phase. Costs on a contact are active while it is held.
/// Instantaneous phases have only costs that name them or their knots.
bool is_on(const BuiltCost& cost, std::size_t p, const PhaseContext& context, Diagnostics& out) {
  const CostSpec& c = *cost.spec;
  const PhaseSpec& phase = context.spec.phases[p];
  if (!context.contacts.find(p, cost.contact.contacts)) return false;
  if (!phase.takes_no_time()) return true;
  if (!names_phase(c, p, context.spec)) return false;
  if (phase.choice) {
    out.error(c.name.place, fmt::format("'{}' is not a place for costs and constraints: it chooses "
                                        "the state of the knot after it",
                                        phase.name.value));
    return false;
  }
  if (needs_control(cost))
    out.error(c.residual.place,
              fmt::format("the residual '{}' needs a control, and the {} '{}' has none",
                          c.residual.value, phase.jump ? "jump" : "impulse", phase.name.value));
  return true;
}

/// For each phase, true if a cost is active.
std::vector<bool> phases_of(const BuiltCost& cost, const PhaseContext& context, Diagnostics& out) {
  std::vector<bool> in_phase = phases_named(cost.spec->phases, context.spec, out);
  for (std::size_t p = 0; p < in_phase.size(); ++p)
    in_phase[p] = in_phase[p] && cost.is_at(p, context.plant) && is_on(cost, p, context, out);
  return in_phase;
}

/// Factors on the running costs of a phase, knot by knot.
std::vector<double> cost_scales(const PhaseSpec& phase, const ProblemSpec& spec) {
  const bool rate = spec.costs_are_rates() && !phase.takes_no_time();
  return rate ? phase_steps(phase) : std::vector<double>(phase.knots.value, 1.0);
}

/// Extends a swing to its last node, the first one after its phases. The touch-down is
/// instantaneous: like at an impulse or the last node, its cost is not multiplied by the time step.
void extend_to_touch_down(const ProblemSpec& spec, std::vector<double>& weights) {
  std::size_t first = weights.size();
  for (std::size_t p = spec.phases.size(); p-- > 0;) {
    first -= spec.phases[p].knots.value;
    if (first > 0 && weights[first] == 0)
      weights[first] = weights[first - 1] / cost_scales(spec.phases[p], spec).front();
  }
}

/// Weight of a cost in a phase.
double weight_in(const PhaseSpec& phase, const CostSpec& cost) {
  double weight = cost.weight;
  for (const auto& [name, value] : phase.weights)
    if (name.value == cost.name.value) weight = value;
  return weight;
}

/// Sets the weights at all other knots to zero.
void restrict_to(const std::vector<KnotSpec>& knots, std::vector<double>& row) {
  std::vector<bool> chosen(row.size(), false);
  for (const KnotSpec& knot : knots) chosen[knot.value] = true;
  for (std::size_t k = 0; k < row.size(); ++k)
    if (!chosen[k]) row[k] = 0;
}

/// Factors on running costs at each knot.
std::vector<double> all_cost_scales(const ProblemSpec& spec) {
  std::vector<double> scales;
  for (const PhaseSpec& phase : spec.phases) {
    const std::vector<double> own = cost_scales(phase, spec);
    scales.insert(scales.end(), own.begin(), own.end());
  }
  return scales;
}

/// Role of a function: a cost, or a hard or soft constraint.
enum class Role { kCost, kHard, kSoft };

Role role_of(const BuiltConstraint& constraint) {
  return constraint.spec->softness == Softness::hard ? Role::kHard : Role::kSoft;
}

/// Activates a constraint also at the nodes where its phases end. The last entry of `nodes` is the
/// last node. The plant variant at that node applies, not that of the phase.
void extend_to_ends(const PhaseContext& context, const BuiltCost& function,
                    std::vector<double>& nodes) {
  const std::vector<bool> named = phases_named(function.spec->phases, context.spec);
  Diagnostics said;  // already reported when scheduled
  std::size_t end = 0;
  for (std::size_t p = 0; p < named.size(); ++p) {
    end += context.spec.phases[p].knots.value;
    if (named[p] && is_on(function, p, context, said) && function.is_at(p + 1, context.plant) &&
        context.contacts.find(p + 1, function.contact.contacts))
      nodes[end] = 1;
  }
}

/// Reports a function of controls or forces, which do not exist at the end of a phase.
void check_ends(const BuiltCost& function, Diagnostics& out) {
  if (needs_control(function) || function.spec->definition->needs.force)
    out.error(function.spec->ends.place,
              fmt::format("'{}' needs a control, and the controls of a phase do not last until the "
                          "node at its end",
                          function.spec->name.value),
              "leave 'nodes' out");
}

/// True if running costs are multiplied by free durations.
bool grows_with_durations(const ProblemSpec& spec) {
  return spec.first_free_duration() != nullptr && spec.costs_are_rates();
}

/// True if a cost is integrated in phases that take time. Excluded are costs at chosen knots,
/// swings, which end at an instant, and costs on the previous control, which the next one replaces.
bool is_integrated(const PhaseContext& context, const BuiltCost& cost) {
  const CostSpec& c = *cost.spec;
  return context.spec.running_costs.value == RunningCosts::kIntegrated &&
         info_of(context.integrator).order > 1 && !c.knots && c.keys.find(key::swing) == nullptr &&
         !c.definition->needs.previous_control && !c.names_previous_control;
}

/// True if a function applies at both ends of its knots. This requires linear controls, and
/// excludes constraints on the state alone, functions at chosen knots, and integrated costs. With
/// free durations it also excludes swings, which end at an instant that no duration multiplies.
bool is_at_both_ends(const PhaseContext& context, const BuiltCost& cost, Role role) {
  if (!context.tail.linear() || cost.spec->knots) return false;
  if (role == Role::kCost && is_integrated(context, cost)) return false;
  const bool swing = cost.spec->keys.find(key::swing) != nullptr;
  if (swing && grows_with_durations(context.spec)) return false;
  return needs_control(cost) || cost.spec->definition->needs.force || role == Role::kCost;
}

/// For each node, true if a phase begins or ends there whose costs scale with a free duration.
/// Costs at the end of the previous knot then have another factor than those of the node.
std::vector<bool> changes_of_duration(const PhaseContext& context) {
  std::vector<bool> changes;
  const std::size_t count = context.spec.phases.size();
  for (std::size_t p = 0; p < count; ++p) {
    const bool free = context.cost_duration(p) || (p > 0 && context.cost_duration(p - 1));
    changes.push_back(free);
    changes.resize(changes.size() + context.spec.phases[p].knots.value - 1, false);
  }
  changes.push_back(context.cost_duration(count - 1).has_value());
  return changes;
}

/// Weight of a cost at each node, 0 if inactive. For a constraint: 1 if active, or the active share
/// with linear controls. The last node has a weight if the function extends to it.
NodeWeights schedule(const PhaseContext& context, const BuiltCost& cost, Role role,
                     Diagnostics& out) {
  const bool weighted = role == Role::kCost;
  const ProblemSpec& spec = context.spec;
  const CostSpec& c = *cost.spec;
  const std::vector<bool> in_phase = phases_of(cost, context, out);
  std::vector<double> row;
  for (std::size_t p = 0; p < spec.phases.size(); ++p) {
    const double weight = weighted ? weight_in(spec.phases[p], c) : c.weight;
    row.insert(row.end(), spec.phases[p].knots.value, in_phase[p] ? weight : 0.0);
  }
  if (c.keys.find(key::swing) != nullptr) extend_to_touch_down(spec, row);
  if (c.knots) restrict_to(*c.knots, row);
  if (is_at_both_ends(context, cost, role))
    return trapezoidal_weights(row, all_cost_scales(spec),
                               role == Role::kHard ? std::vector<bool>(row.size() + 1, false)
                                                   : changes_of_duration(context));
  row.push_back(0);
  if (c.ends.value) {
    check_ends(cost, out);
    extend_to_ends(context, cost, row);
  }
  return {std::move(row)};
}

/// Terms that are active somewhere in a run of knots.
std::vector<int> active_in(const std::vector<NodeWeights>& weights, int first, int count) {
  std::vector<int> active;
  for (std::size_t c = 0; c < weights.size(); ++c) {
    const auto begin = weights[c].nodes.begin() + first;
    if (std::any_of(begin, begin + count, [](double w) { return w != 0; }))
      active.push_back(static_cast<int>(c));
  }
  return active;
}

/// Terms with a separate weight at a node for the end of the knot before it.
std::vector<int> ending_at(const std::vector<NodeWeights>& weights, int node) {
  std::vector<int> ending;
  for (std::size_t c = 0; c < weights.size(); ++c)
    if (weights[c].end(node) != 0) ending.push_back(static_cast<int>(c));
  return ending;
}

/// True if a swing ends at the last node: it lasts until then, and the node holds the foot.
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

/// Residual of a cost in the system of a phase or of the last node.
std::shared_ptr<const Residual> residual_in(const BuiltCost& cost, const PhaseContext& context,
                                            std::size_t phase) {
  if (!cost.contact.make) return cost.residual.residual;
  const bool at_the_end = phase == context.contacts.terminal();
  const auto& system = at_the_end ? context.system : context.contacts.system(phase);
  return cost.contact.make(std::static_pointer_cast<const MultibodySystem>(system),
                           *context.contacts.find(phase, cost.contact.contacts));
}

/// Knot that chooses the initial state and, within bounds, the first linear controls.
Phase choice_phase(const PhaseSpec& given, const StateTail& tail,
                   const std::vector<double>& control_lower,
                   const std::vector<double>& control_upper) {
  const InitialChoice& choice = *tail.start;
  auto model = std::make_shared<KnotModel>(tail.choice());
  std::vector<double> lower = choice.lower, upper = choice.upper;
  std::copy_n(control_lower.begin(), choice.first_controls, lower.end() - choice.first_controls);
  std::copy_n(control_upper.begin(), choice.first_controls, upper.end() - choice.first_controls);
  model->set_control_bounds(std::move(lower), std::move(upper));
  return {.name = given.name.value,
          .model = std::move(model),
          .dt = {1.0},
          .cost_scale = {1.0},
          .parameters = {},
          .instant = true};
}

/// Warns of controls without an effort limit in the URDF that is to bound them.
void warn_of_unbounded(const ConstraintSpec& constraint, const std::vector<std::string>& names,
                       const std::vector<double>& lower, const std::vector<double>& upper,
                       Diagnostics& out) {
  std::vector<std::string> without;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (std::isinf(lower[i]) && std::isinf(upper[i])) without.push_back("'" + names[i] + "'");
  if (without.empty()) return;
  if (without.size() == names.size())
    return out.warning(*constraint.from_urdf, "the URDF gives no effort limit to any control");
  out.warning(*constraint.from_urdf,
              fmt::format("the URDF gives no effort limit to {}", fmt::join(without, ", ")),
              "without 'lower' and 'upper' for it a control stays unbounded");
}

/// Replaces bounds of some controls by those of the file if they are `better`.
template <class Better>
void narrow(const std::optional<ComponentsSpec>& given, const ComponentNames& names, double none,
            Better better, std::vector<double>& bounds, Diagnostics& out) {
  if (!given) return;
  if (const auto values = resolve(*given, names, none, out))
    for (std::size_t i = 0; i < bounds.size(); ++i) bounds[i] = better(bounds[i], (*values)[i]);
}

/// Sets the bounds of the named phases.
void bound_phases(const std::vector<bool>& named, const std::vector<double>& lower,
                  const std::vector<double>& upper, PhaseBounds& bounds) {
  for (std::size_t p = 0; p < named.size(); ++p) {
    if (!named[p]) continue;
    std::copy(lower.begin(), lower.end(), bounds.lower[p].begin());
    std::copy(upper.begin(), upper.end(), bounds.upper[p].begin());
  }
}

/// Writes the parameters of a constraint with an active share at a node.
void write_constraint(const BuiltConstraint& constraint, const ConstraintTerm& term,
                      const NodeTime& time, double share, double* parameters) {
  write_parameters(constraint, term, time, share != 0, parameters);
  if (term.softness != Softness::hard && share != 0) parameters[term.weight()] *= share;
}

/// Constraint term that grows, if soft, with the duration of a phase.
ConstraintTerm growing_term(const BuiltConstraint& constraint,
                            std::shared_ptr<const Residual> residual, const PhaseContext& context,
                            std::size_t phase) {
  ConstraintTerm term = make_term(constraint, std::move(residual), context.cost_duration(phase));
  term.grows_with = context.cost_growth(phase);
  return term;
}

/// Builds phases; phases with the same structure share their model.
class PhaseBuilder {
 public:
  PhaseBuilder(const PhaseContext& context, const KnotContents& contents, const PhaseBounds& bounds,
               Diagnostics& out)
      : context_(context), contents_(contents), bounds_(bounds) {
    for (const BuiltCost& cost : contents.costs)
      weights_.push_back(schedule(context, cost, Role::kCost, out));
    for (const BuiltConstraint& constraint : contents.constraints)
      switches_.push_back(schedule(context, constraint.function, role_of(constraint), out));
    for (const BuiltCost& integral : contents.integrals)
      grows_.push_back(phases_of(integral, context, out));
  }

  /// Builds phase p, whose first knot is `first`.
  Phase build(std::size_t p, int first) {
    const PhaseSpec& given = context_.spec.phases[p];
    if (given.choice)
      return choice_phase(given, context_.tail, bounds_.lower.back(), bounds_.upper.back());
    const Contents terms = contents_of(p, first);
    Phase phase{.name = given.name.value, .model = shared_model(p, terms)};
    phase.dt = phase_steps(given);
    phase.cost_scale = cost_scales(given, context_.spec);
    const int count = phase.model->parameter_count();
    phase.parameters.resize(static_cast<std::size_t>(given.knots.value) * count);
    for (int k = 0; k < given.knots.value; ++k)
      write_knot(*phase.model, terms, p, first + k, phase.dt[k],
                 phase.parameters.data() + k * count);
    return phase;
  }

 private:
  /// A cost or constraint that is active somewhere in a phase.
  struct Use {
    int content;  ///< index among the contents
    bool at_end;  ///< true if it applies at the end of the knot before the first one
    std::optional<FreeDuration> grows_with;

    auto operator<=>(const Use&) const = default;
  };
  /// Terms of a phase; costs and constraints at the end of the previous phase come last.
  struct Contents {
    std::vector<Use> costs, constraints;
    std::vector<int> integrals;

    auto operator<=>(const Contents&) const = default;
  };
  /// Phases with equal structure share their model.
  struct Structure {
    const System* system;
    std::optional<FreeDuration> duration;
    Contents contents;
    std::vector<double> lower, upper;

    auto operator<=>(const Structure&) const = default;
  };

  Contents contents_of(std::size_t p, int first) const {
    const int count = context_.spec.phases[p].knots.value;
    const std::vector<int> moments = context_.cost_growth(p) ? touch_downs(p) : std::vector<int>{};
    Contents contents{{}, {}, integrals_in(p)};
    for (const int c : active_in(weights_, first, count)) {
      const bool is_moment = std::ranges::find(moments, c) != moments.end();
      contents.costs.push_back({c, false, is_moment ? std::nullopt : context_.cost_growth(p)});
    }
    for (const int c : active_in(switches_, first, count))
      contents.constraints.push_back({c, false, context_.cost_growth(p)});
    if (p == 0) return contents;
    for (const int c : ending_at(weights_, first))
      contents.costs.push_back({c, true, context_.cost_growth(p - 1)});
    for (const int c : ending_at(switches_, first))
      contents.constraints.push_back({c, true, context_.cost_growth(p - 1)});
    return contents;
  }

  /// Integrals that grow in a phase.
  std::vector<int> integrals_in(std::size_t p) const {
    std::vector<int> integrals;
    for (std::size_t i = 0; i < grows_.size(); ++i)
      if (grows_[i][p]) integrals.push_back(static_cast<int>(i));
    return integrals;
  }

  /// Swings that end where a phase begins: at an instant, which no duration multiplies.
  std::vector<int> touch_downs(std::size_t p) const {
    std::vector<int> costs;
    for (std::size_t c = 0; c < contents_.costs.size(); ++c) {
      const CostSpec& cost = *contents_.costs[c].spec;
      Diagnostics said;  // already reported when scheduled
      if (cost.keys.find(key::swing) != nullptr &&
          !phases_named(cost.phases, context_.spec, said)[p])
        costs.push_back(static_cast<int>(c));
    }
    return costs;
  }

  std::shared_ptr<const KnotModel> shared_model(std::size_t p, const Contents& contents) {
    auto& model = models_[{context_.contacts.system(p).get(), context_.tail.duration(p), contents,
                           bounds_.lower[p], bounds_.upper[p]}];
    if (!model) model = make_model(p, contents);
    return model;
  }

  /// True if the model has collocation equations; false for jumps.
  bool collocates(const KnotModel& model) const {
    return context_.collocates && model.system().as_collocation() != nullptr;
  }

  Integrator integrator_of(const PhaseSpec& phase) const {
    if (phase.jump) return Integrator::discrete;
    return phase.restitution ? Integrator::impulse : context_.integrator;
  }

  Step make_step(std::size_t p, const Contents& contents) const {
    const PhaseSpec& phase = context_.spec.phases[p];
    const auto& system = context_.contacts.system(p);
    Step step = phase.takes_no_time() ? context_.tail.instant(system, integrator_of(phase))
                                      : context_.tail.step(system, integrator_of(phase));
    if (const auto duration = context_.tail.duration(p)) step.scale_time(*duration);
    for (const int i : contents.integrals) {
      const BuiltCost& integral = contents_.integrals[i];
      step.integrate(integral.spec->name.value, residual_in(integral, context_, p),
                     number_of(integral));
    }
    return step;
  }

  std::shared_ptr<const KnotModel> make_model(std::size_t p, const Contents& contents) const {
    const bool takes_time = !context_.spec.phases[p].takes_no_time();
    auto model = std::make_shared<KnotModel>(make_step(p, contents));
    for (const Use& use : contents.costs) {
      const BuiltCost& cost = contents_.costs[use.content];
      model->add_cost(cost.spec->name.value, residual_in(cost, context_, p), cost.activation,
                      use.grows_with, !use.at_end && takes_time && is_integrated(context_, cost));
    }
    for (const Use& use : contents.constraints) {
      const BuiltConstraint& constraint = contents_.constraints[use.content];
      model->add_constraint(growing_term(constraint, residual_in(constraint.function, context_, p),
                                         context_, use.at_end ? p - 1 : p));
    }
    if (context_.stepping) add_stepping_terms(context_.stepping, *model);
    if (takes_time) model->set_control_bounds(bounds_.lower[p], bounds_.upper[p]);
    if (collocates(*model)) add_collocation_terms(*model);
    return model;
  }

  struct KnotPlace {
    std::size_t phase;
    int knot;
    double dt;
  };
  /// Writes the parameters of an integrated cost at the stages of a knot.
  void write_stages(const KnotModel& model, std::size_t term, const BuiltCost& cost,
                    const KnotPlace& place, double* parameters) const {
    double* to = parameters + model.costs()[term].parameters;
    for (const QuadratureStage& stage : model.quadrature()) {
      const std::vector<double> own =
          residual_parameters(cost, time_within(context_.times[place.knot], place.dt, stage.time,
                                                context_.spec, place.phase));
      to = std::copy(own.begin(), own.end(), to);
    }
  }

  /// Writes the parameters of a knot of length dt.
  void write_knot(const KnotModel& model, const Contents& contents, std::size_t phase, int knot,
                  double dt, double* parameters) const {
    const NodeTime& time = context_.times[knot];
    for (std::size_t i = 0; i < contents.costs.size(); ++i) {
      const auto& [c, at_end, growth] = contents.costs[i];
      write_parameters(contents_.costs[c], model.costs()[i], time,
                       at_end ? weights_[c].end(knot) : weights_[c].nodes[knot], parameters);
      if (model.costs()[i].integrated)
        write_stages(model, i, contents_.costs[c], {phase, knot, dt}, parameters);
    }
    for (std::size_t i = 0; i < contents.constraints.size(); ++i) {
      const auto& [c, at_end, growth] = contents.constraints[i];
      write_constraint(contents_.constraints[c], model.constraints()[i], time,
                       at_end ? switches_[c].end(knot) : switches_[c].nodes[knot], parameters);
    }
    for (std::size_t i = 0; i < contents.integrals.size(); ++i) {
      const std::vector<double> own =
          residual_parameters(contents_.integrals[contents.integrals[i]], time);
      std::copy(own.begin(), own.end(), parameters + model.step().integrals()[i].parameters);
    }
    if (context_.stepping)
      write_stepping_parameters(model, dt, context_.spec.stepping->regularization, parameters);
    if (collocates(model)) write_collocation_parameters(model, dt, parameters);
  }

  /// Index of an integral in the tail of the state.
  int number_of(const BuiltCost& integral) const {
    return static_cast<int>(integral.spec - context_.spec.integrals.data());
  }

  const PhaseContext& context_;
  const KnotContents& contents_;
  const PhaseBounds& bounds_;
  std::vector<NodeWeights> weights_, switches_;  ///< of costs and constraints
  std::vector<std::vector<bool>> grows_;         ///< active phases of each integral
  std::map<Structure, std::shared_ptr<const KnotModel>> models_;
};

/// True if the last node can evaluate a function; reports a residual that needs a control.
bool is_without_control(const BuiltCost& function, const PhaseContext& context, Diagnostics& out) {
  if (function.contact.make || context.tail.linear() ||
      !function.residual.residual->needs_control())
    return true;
  out.error(function.spec->residual.place,
            "this residual needs a control, and there is none at the terminal node");
  return false;
}

/// True if the last node holds the contact of a residual. Reports a contact that is named but not
/// held.
bool is_held_at_the_end(const BuiltCost& function, const PhaseContext& context, Diagnostics& out) {
  const std::size_t node = context.contacts.terminal();
  if (context.contacts.find(node, function.contact.contacts)) return true;
  const bool none = context.contacts.held(node).empty();
  if (none || !function.spec->keys.value(key::contacts).all)
    out.error(
        function.spec->residual.place,
        none ? "the last node holds no contact"
             : fmt::format("the last node does not hold the contact '{}'",
                           context.spec.contacts[function.contact.contacts.front()].name.value),
        "write 'terminal: {contacts: [...]}'");
  return false;
}

bool fits_the_end(const BuiltCost& function, const PhaseContext& context, Diagnostics& out) {
  return is_held_at_the_end(function, context, out) && is_without_control(function, context, out);
}

/// A term at the last node with its weight there; for a constraint, its active share.
template <class Term>
struct TermAtTheEnd {
  const Term* term;
  double weight;
  bool is_end = false;  ///< true for the end of the last knot, multiplied by its duration
};
template <class Term>
using TermsAtTheEnd = std::vector<TermAtTheEnd<Term>>;

/// Adds running terms that extend to the last node.
template <class Term>
void add_rest(const Term& term, const NodeWeights& weights, TermsAtTheEnd<Term>& terms) {
  const int last = static_cast<int>(weights.nodes.size()) - 1;
  if (const double own = weights.nodes[last]; own != 0) terms.push_back({&term, own});
  if (const double end = weights.end(last); end != 0) terms.push_back({&term, end, true});
}

/// Costs of the last node: its own, those on swings that end there, and with linear controls those
/// of the last knot.
TermsAtTheEnd<BuiltCost> costs_at_the_end(const PhaseContext& context,
                                          const std::vector<BuiltCost>& running,
                                          const std::vector<BuiltCost>& terminal,
                                          Diagnostics& out) {
  TermsAtTheEnd<BuiltCost> costs;
  for (const BuiltCost& cost : terminal)
    if (fits_the_end(cost, context, out)) costs.push_back({&cost, cost.spec->weight});
  for (const BuiltCost& cost : running) {
    if (touches_down_at_the_end(cost, context, out))
      costs.push_back({&cost, cost.spec->weight});
    else
      add_rest(cost, schedule(context, cost, Role::kCost, out), costs);
  }
  return costs;
}

TermsAtTheEnd<BuiltConstraint> constraints_at_the_end(const PhaseContext& context,
                                                      const std::vector<BuiltConstraint>& running,
                                                      const std::vector<BuiltConstraint>& terminal,
                                                      Diagnostics& out) {
  TermsAtTheEnd<BuiltConstraint> constraints;
  for (const BuiltConstraint& constraint : terminal)
    if (fits_the_end(constraint.function, context, out)) constraints.push_back({&constraint, 1});
  for (const BuiltConstraint& constraint : running) {
    if (constraint.at_last_node &&
        constraint.function.is_at(context.spec.phases.size(), context.plant))
      constraints.push_back({&constraint, 1});
    else
      add_rest(constraint, schedule(context, constraint.function, role_of(constraint), out),
               constraints);
  }
  return constraints;
}

/// Row of a constraint furthest outside its bounds; empty for cones and pairs.
std::optional<int> worst_row(const ConstraintTerm& term, const double* values, const double* lower,
                             const double* upper) {
  if (!term.has_bounds() || term.has_pairs()) return std::nullopt;
  std::vector<double> outside(term.rows);
  for (int i = 0; i < term.rows; ++i)
    outside[i] = std::abs(outside_bounds(values[i], lower[i], upper[i]));
  return worst_of(outside);
}

void report_violation(const std::string& name, std::optional<int> row, double violation,
                      const std::vector<BuiltConstraint>& constraints, Diagnostics& out) {
  const auto violated =
      std::find_if(constraints.begin(), constraints.end(), [&](const BuiltConstraint& constraint) {
        return constraint.spec->function.name.value == name;
      });
  if (violated == constraints.end()) return;
  const std::vector<std::string>& rows = violated->function.residual.rows.names;
  const bool named = row && rows.size() > 1 && *row < static_cast<int>(rows.size());
  out.error(violated->spec->function.name.place,
            fmt::format("the initial state violates the constraint '{}' by {:.3g}{}", name,
                        violation, named ? fmt::format(" ('{}')", rows[*row]) : ""),
            "no control can change that: move the initial state, or name the constraint's 'phases' "
            "or 'knots' without knot 0");
}

}  // namespace

PhaseBounds unbounded(const ProblemSpec& spec, const Plant& plant) {
  PhaseBounds bounds;
  for (std::size_t p = 0; p < spec.phases.size(); ++p) {
    const int nu = plant.variants.empty() ? plant.system->nu() : plant.system_in(p)->nu();
    bounds.lower.emplace_back(nu, -kUnlimited);
    bounds.upper.emplace_back(nu, kUnlimited);
  }
  return bounds;
}

namespace {

/// Bounds of a constraint on the controls of a plant.
struct ControlInterval {
  ComponentNames names;
  std::vector<double> lower, upper;
};

std::optional<ControlInterval> interval_of(const ConstraintSpec& constraint, const Plant& plant,
                                           Diagnostics& out) {
  const int errors = out.error_count();
  ControlInterval interval{control_names(plant), {}, {}};
  auto& [names, lower, upper] = interval;
  lower.assign(names.names.size(), -kUnlimited);
  upper.assign(names.names.size(), kUnlimited);
  if (constraint.from_urdf) {
    lower = plant.actuated().control_lower();
    upper = plant.actuated().control_upper();
    scale_efforts(constraint.scale, lower, upper);
    if (!plant.multibody())
      out.error(*constraint.from_urdf, "a closed-form system has no URDF",
                "give 'lower' and 'upper'");
  }
  const auto larger = [](double a, double b) { return std::max(a, b); };
  const auto smaller = [](double a, double b) { return std::min(a, b); };
  narrow(constraint.lower, names, -kUnlimited, larger, lower, out);
  narrow(constraint.upper, names, kUnlimited, smaller, upper, out);
  if (out.error_count() > errors) return std::nullopt;
  return interval;
}

/// Keeps only the phases with the controls of a variant.
std::vector<bool> phases_of_variant(std::size_t variant, std::vector<bool> phases,
                                    const ProblemSpec& spec, const Plant& plant) {
  if (plant.variants.empty()) return phases;
  for (std::size_t p = 0; p < phases.size(); ++p)
    if (spec.phases[p].takes_no_time() || plant.variant_at[p] != variant) phases[p] = false;
  return phases;
}

}  // namespace

std::optional<PhaseBounds> build_control_bounds(const ConstraintSpec& constraint,
                                                const ProblemSpec& spec, const Plant& plant,
                                                Diagnostics& out) {
  const int errors = out.error_count();
  if (plant.all_controls().empty())
    out.error(constraint.function.name.place, "the system has no control that could have bounds",
              "write 'bounds: state', or give the system controls");
  const std::vector<bool> named = phases_named(constraint.function.phases, spec, out);
  PhaseBounds bounds = unbounded(spec, plant);
  const std::vector<Plant> variants = plant.all_variants();
  for (std::size_t v = 0; v < variants.size(); ++v) {
    const std::vector<bool> own = phases_of_variant(v, named, spec, plant);
    if (variants.size() > 1 && std::ranges::find(own, true) == own.end()) continue;
    const auto interval = interval_of(constraint, variants[v], out);
    if (!interval || out.error_count() > errors) return std::nullopt;
    if (constraint.from_urdf)
      warn_of_unbounded(constraint, interval->names.names, interval->lower, interval->upper, out);
    bound_phases(own, interval->lower, interval->upper, bounds);
  }
  return out.error_count() > errors ? std::nullopt : std::optional(std::move(bounds));
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
      const System& system = plant.variants.empty() ? *plant.system : *plant.system_in(p);
      return out.error(
          name.place, fmt::format("no value of '{}' satisfies the bounds: the lower one is {}, the "
                                  "upper one {}",
                                  system.control_columns()[i].name, lower, upper));
    }
}

std::vector<Phase> build_phases(const PhaseContext& context, const KnotContents& contents,
                                const PhaseBounds& bounds, Diagnostics& out) {
  const ProblemSpec& spec = context.spec;
  check_weights(spec, out);
  PhaseBuilder builder(context, contents, bounds, out);
  if (out.has_errors()) return {};
  std::vector<Phase> phases;
  int first = 0;
  for (std::size_t p = 0; p < spec.phases.size(); ++p) {
    phases.push_back(builder.build(p, first));
    first += spec.phases[p].knots.value;
  }
  return phases;
}

Phase build_terminal(const PhaseContext& context, const KnotContents& running,
                     const KnotContents& terminal, const TerminalLqr* lqr, Diagnostics& out) {
  auto model = std::make_shared<KnotModel>(context.tail.step(context.system, Integrator::none));
  const std::size_t node = context.contacts.terminal();
  const auto costs = costs_at_the_end(context, running.costs, terminal.costs, out);
  const auto constraints =
      constraints_at_the_end(context, running.constraints, terminal.constraints, out);
  for (const auto& [cost, weight, is_end] : costs)
    model->add_cost(cost->spec->name.value, residual_in(*cost, context, node), cost->activation,
                    is_end ? context.cost_growth(node - 1) : std::nullopt);
  for (const auto& [constraint, share, is_end] : constraints) {
    auto residual = residual_in(constraint->function, context, node);
    model->add_constraint(is_end ? growing_term(*constraint, std::move(residual), context, node - 1)
                                 : make_term(*constraint, std::move(residual)));
  }
  Phase phase{.name = "terminal", .dt = {0.0}, .cost_scale = {1.0}};
  phase.parameters.resize(model->parameter_count());
  for (std::size_t i = 0; i < costs.size(); ++i)
    write_parameters(*costs[i].term, model->costs()[i], context.times.back(), costs[i].weight,
                     phase.parameters.data());
  for (std::size_t i = 0; i < constraints.size(); ++i)
    write_constraint(*constraints[i].term, model->constraints()[i], context.times.back(),
                     constraints[i].weight, phase.parameters.data());
  if (lqr) add_terminal_lqr(*lqr, *model, phase.parameters);
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
    if (violation > tolerance)
      report_violation(term.name,
                       worst_row(term, work.constraint.data() + term.row, lower, lower + term.rows),
                       violation, constraints, out);
  }
}

}  // namespace conddp
