#include "problem_file/build/constraint_builder.hpp"
#include "problem_file/expand/expand_sections.hpp"
#include "problem_file/plant/shape_pairs.hpp"
#include "problem_file/spec/enum_names.hpp"

namespace conddp {
namespace {

OrderedJson expand_activation(const ActivationSpec& activation) {
  const std::string kind = word_of(kActivationWords, activation.kind);
  if (activation.kind == ActivationKind::quadratic) return OrderedJson(kind);
  OrderedJson json = {{"kind", kind}};
  if (activation.kind != ActivationKind::quadratic_barrier) {
    json["epsilon"] = activation.epsilon;
    return json;
  }
  if (activation.from_urdf) json["from"] = "urdf";
  if (activation.lower) json["lower"] = expand_components(*activation.lower);
  if (activation.upper) json["upper"] = expand_components(*activation.upper);
  return json;
}

void expand_cone(const CostSpec& cost, OrderedJson& json) {
  const FrictionConeSpec& cone = cost.cone;
  if (cost.kind == ResidualKind::kFrictionCone) {
    json["cone"] = word_of(kConeWords, cone.second_order);
    if (!cone.second_order) json["faces"] = cone.faces;
  }
  if (cost.kind == ResidualKind::kCenterOfPressure) return;
  if (!cone.second_order) json["inner"] = cone.inner;
  json["safety"] = cone.safety;
}

OrderedJson expand_swing(const SwingSpec& swing) {
  OrderedJson json = {{"height", swing.height}};
  if (swing.landing)
    json["landing"] = expand_vector(*swing.landing);
  else if (!swing.displaced.empty())
    for (const PlanarMotion& motion : swing.displaced)
      json["displaced"].push_back(expand_motion(motion));
  else
    json["step"] = expand_vector(swing.step.value_or(Vector3<double>::zero()));
  return json;
}

OrderedJson expand_joints(const CostSpec& cost, const Plant& plant) {
  if (cost.joints) return expand_names(*cost.joints);
  return OrderedJson(joint_names(plant.robot()));
}

OrderedJson expand_pairs(const CostSpec& cost, const ProblemSpec& spec, const Plant& plant) {
  Diagnostics found_when_built;
  OrderedJson json = OrderedJson::array();
  for (const ShapePair& pair : shape_pairs(cost, spec, plant, found_when_built))
    json.push_back({pair.first, pair.second});
  return json;
}

/// What a residual is on.
OrderedJson expand_residual(const CostSpec& cost, const ProblemSpec& spec, const Plant& plant,
                            bool terminal) {
  OrderedJson json = {{"residual", cost.residual.value}};
  if (cost.frame) json["frame"] = cost.frame->value;
  if (residual_info(cost.kind).takes_joints) json["joints"] = expand_joints(cost, plant);
  if (cost.columns) json["columns"] = expand_names(*cost.columns);
  if (cost.kind == ResidualKind::kFrameVelocity) json["axes"] = word_of(kAxesWords, cost.axes);
  const ResidualInfo& info = residual_info(cost.kind);
  if (info.of_contacts) {
    const bool held = terminal && cost.contacts.all;
    json["contacts"] = expand_contact_names(held ? spec.last_contacts() : cost.contacts, spec);
  }
  if (info.is_cone) expand_cone(cost, json);
  for (const NamedNumbers& row : cost.combinations) json["rows"].push_back(expand_numbers(row));
  if (cost.kind == ResidualKind::kCycle)
    json["offset"] = cost.offset ? expand_components(*cost.offset) : OrderedJson(0.0);
  if (info.of_shapes) json["pairs"] = expand_pairs(cost, spec, plant);
  return json;
}

/// Where a cost or constraint holds.
void expand_place(const CostSpec& cost, const ProblemSpec& spec, OrderedJson& json) {
  json["phases"] = expand_phase_names(cost.phases, spec);
  if (!cost.knots) return;
  OrderedJson knots = OrderedJson::array();
  for (const Located<int>& knot : *cost.knots) knots.push_back(knot.value);
  json["knots"] = std::move(knots);
}

OrderedJson expand_cost(const CostSpec& cost, const ProblemSpec& spec, const Plant& plant,
                        bool terminal) {
  OrderedJson json = expand_residual(cost, spec, plant, terminal);
  const ResidualInfo& info = residual_info(cost.kind);
  if (cost.swing) json["swing"] = expand_swing(*cost.swing);
  if (cost.margin) json["margin"] = *cost.margin;
  json["weight"] = cost.weight;
  json["weights"] = cost.weights ? expand_components(*cost.weights) : OrderedJson(1.0);
  if (!info.is_cone && !cost.margin) json["activation"] = expand_activation(cost.activation);
  if (OrderedJson reference = expand_reference(cost); !reference.is_null() && !cost.swing)
    json["reference"] = std::move(reference);
  if (!terminal) expand_place(cost, spec, json);
  return json;
}

OrderedJson expand_constraint(const ConstraintSpec& constraint, const ProblemSpec& spec,
                              const Plant& plant, bool terminal) {
  const CostSpec& function = constraint.function;
  OrderedJson json;
  const auto bounds = [&] {
    if (constraint.lower) json["lower"] = expand_components(*constraint.lower);
    if (constraint.upper) json["upper"] = expand_components(*constraint.upper);
  };
  const auto softness = [&] {
    if (constraint.softness == Softness::hard) return;
    json["soft"] = word_of(kSoftWords, constraint.softness);
    json["weight"] = constraint.weight;
  };
  if (constraint.bounded) {
    json["bounds"] = word_of(kBoundedWords, constraint.bounded->value);
    if (constraint.from_urdf) json.update({{"from", "urdf"}, {"scale", constraint.scale}});
    bounds();
    softness();
    // Named phases leave the last node out, so that all of them are not named here.
    if (function.phases) json["phases"] = expand_names(*function.phases);
    return json;
  }
  json = expand_residual(function, spec, plant, terminal);
  for (const Located<std::vector<double>>& center : constraint.centers)
    json["centers"].push_back(center.value);
  if (OrderedJson reference = expand_reference(function);
      !reference.is_null() && constraint.centers.empty())
    json["reference"] = std::move(reference);
  if (constraint.at_least) json["at_least"] = *constraint.at_least;
  if (constraint.at_most) json["at_most"] = *constraint.at_most;
  bounds();
  const bool of_contacts = residual_info(function.kind).of_contacts;
  if (function.cone.second_order) {
    json["cone"] = "second_order";
    if (!of_contacts) json["slope"] = constraint.slope;
  } else if (constraint.equals) {
    json["equals"] = expand_components(*constraint.equals);
  } else if (is_zero(constraint)) {
    json["equals"] = 0.0;
  }
  softness();
  if (!terminal) expand_place(function, spec, json);
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
