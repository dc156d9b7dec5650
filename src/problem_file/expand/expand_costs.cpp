#include <algorithm>

#include "problem_file/expand/expand_sections.hpp"
#include "problem_file/residuals/residual_keys.hpp"
#include "problem_file/spec/enum_names.hpp"
#include "problem_file/terms/constraint_builder.hpp"
#include "problem_file/values/activation_table.hpp"

namespace conddp {
namespace {

/// True if a key of the residual replaces another key.
bool is_excluded(std::string_view key, const CostSpec& cost) {
  const auto& keys = cost.definition->keys;
  return std::any_of(keys.begin(), keys.end(), [&](const ResidualKey* own) {
    return own->traits.excludes == key && cost.keys.has(own->name);
  });
}

/// Phases and knots of a cost or constraint.
void expand_place(const CostSpec& cost, const ProblemSpec& spec, OrderedJson& json) {
  // Knots alone may belong to phases that take no time; then the phases must not be named.
  if (cost.phases || !cost.knots) json["phases"] = expand_phase_names(cost.phases, spec);
  if (!cost.knots) return;
  OrderedJson knots = OrderedJson::array();
  for (const Located<int>& knot : *cost.knots) knots.push_back(knot.value);
  json["knots"] = std::move(knots);
}

OrderedJson expand_cost(const CostSpec& cost, const ProblemSpec& spec, const Plant& plant,
                        bool terminal) {
  OrderedJson json = expand_residual_keys(cost, {spec, plant, {.last_node = terminal}});
  json["weight"] = cost.weight;
  if (cost.matrix)
    json["matrix"] = expand_symmetric_matrix(*cost.matrix);
  else
    json["weights"] = cost.weights ? expand_components(*cost.weights) : OrderedJson(1.0);
  if (!cost.definition->is_cone && !is_excluded("activation", cost))
    json["activation"] = expand_activation(cost.activation);
  if (OrderedJson reference = expand_reference(cost);
      !reference.is_null() && !is_excluded("reference", cost))
    json["reference"] = std::move(reference);
  if (!terminal) expand_place(cost, spec, json);
  return json;
}

void expand_interval(const ConstraintSpec& constraint, OrderedJson& json) {
  if (constraint.lower) json["lower"] = expand_components(*constraint.lower);
  if (constraint.upper) json["upper"] = expand_components(*constraint.upper);
}

void expand_softness(const ConstraintSpec& constraint, OrderedJson& json) {
  if (constraint.softness == Softness::hard) return;
  json["soft"] = word_of(kSoftWords, constraint.softness);
  json["weight"] = constraint.weight;
}

OrderedJson expand_bounds(const ConstraintSpec& constraint) {
  OrderedJson json;
  json["bounds"] = word_of(kBoundedWords, constraint.bounded->value);
  if (constraint.from_urdf) json.update({{"from", "urdf"}, {"scale", constraint.scale}});
  expand_interval(constraint, json);
  expand_softness(constraint, json);
  // Named phases exclude the last node, so the default is not written as all names.
  if (constraint.function.phases) json["phases"] = expand_names(*constraint.function.phases);
  json["nodes"] = word_of(kNodesWords, constraint.function.ends.value);
  return json;
}

/// Reference of a constraint's residual: one point or several.
void expand_origin(const ConstraintSpec& constraint, OrderedJson& json) {
  for (const Located<std::vector<double>>& center : constraint.centers)
    json["centers"].push_back(center.value);
  if (!constraint.centers.empty()) return;
  if (OrderedJson reference = expand_reference(constraint.function); !reference.is_null())
    json["reference"] = std::move(reference);
}

/// The set of a constraint's residual.
void expand_set(const ConstraintSpec& constraint, OrderedJson& json) {
  const CostSpec& function = constraint.function;
  if (constraint.at_least) json["at_least"] = *constraint.at_least;
  if (constraint.at_most) json["at_most"] = *constraint.at_most;
  expand_interval(constraint, json);
  if (function.keys.value(key::cone)) {
    json["cone"] = "second_order";
    if (!function.definition->of_contacts()) json["slope"] = constraint.slope;
  } else if (constraint.equals) {
    json["equals"] = expand_components(*constraint.equals);
  } else if (is_zero(constraint)) {
    json["equals"] = 0.0;
  }
}

OrderedJson expand_constraint(const ConstraintSpec& constraint, const ProblemSpec& spec,
                              const Plant& plant, bool terminal) {
  if (constraint.bounded) return expand_bounds(constraint);
  const CostSpec& function = constraint.function;
  OrderedJson json =
      expand_residual_keys(function, {spec, plant, {.constraint = true, .last_node = terminal}});
  expand_origin(constraint, json);
  expand_set(constraint, json);
  expand_softness(constraint, json);
  if (terminal) return json;
  expand_place(function, spec, json);
  if (!function.knots) json["nodes"] = word_of(kNodesWords, function.ends.value);
  return json;
}

}  // namespace

OrderedJson expand_phase_names(const std::optional<std::vector<Name>>& names,
                               const ProblemSpec& spec) {
  if (names) return expand_names(*names);
  OrderedJson all = OrderedJson::array();
  for (const PhaseSpec& phase : spec.phases)
    if (!phase.takes_no_time()) all.push_back(phase.name.value);
  return all;
}

OrderedJson expand_costs(const std::vector<CostSpec>& costs, const ProblemSpec& spec,
                         const Plant& plant, bool terminal) {
  OrderedJson json = OrderedJson::object();
  for (const CostSpec& cost : costs)
    json[cost.name.value] = expand_cost(cost, spec, plant, terminal);
  return json;
}

OrderedJson expand_constraints(const ProblemSpec& spec, const Plant& plant) {
  OrderedJson json = OrderedJson::object();
  for (const ControlBoundsSpec& constraint : spec.control_bounds) {
    OrderedJson entry = {{"bounds", "control"}};
    if (constraint.from_urdf) entry.update({{"from", "urdf"}, {"scale", constraint.scale}});
    if (constraint.lower) entry["lower"] = expand_components(*constraint.lower);
    if (constraint.upper) entry["upper"] = expand_components(*constraint.upper);
    entry["phases"] = expand_phase_names(constraint.phases, spec);
    json[constraint.name.value] = std::move(entry);
  }
  for (const ConstraintSpec& constraint : spec.constraints)
    json[constraint.function.name.value] = expand_constraint(constraint, spec, plant, false);
  return json;
}

OrderedJson expand_terminal_constraints(const ProblemSpec& spec, const Plant& plant) {
  OrderedJson json = OrderedJson::object();
  for (const ConstraintSpec& constraint : spec.terminal_constraints)
    json[constraint.function.name.value] = expand_constraint(constraint, spec, plant, true);
  return json;
}

}  // namespace conddp
