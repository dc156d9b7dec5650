#include "problem_file/expand_sections.hpp"
#include "problem_file/words.hpp"

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

OrderedJson expand_cost(const CostSpec& cost, const ProblemSpec& spec, const Plant& plant,
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
  if (cost.swing) json["swing"] = expand_swing(*cost.swing);
  json["weight"] = cost.weight;
  json["weights"] = cost.weights ? expand_components(*cost.weights) : OrderedJson(1.0);
  if (!info.is_cone) json["activation"] = expand_activation(cost.activation);
  if (OrderedJson reference = expand_reference(cost); !reference.is_null() && !cost.swing)
    json["reference"] = std::move(reference);
  if (terminal) return json;
  json["phases"] = expand_phase_names(cost.phases, spec);
  if (!cost.knots) return json;
  OrderedJson knots = OrderedJson::array();
  for (const Located<int>& knot : *cost.knots) knots.push_back(knot.value);
  json["knots"] = std::move(knots);
  return json;
}

}  // namespace

OrderedJson expand_phase_names(const std::optional<std::vector<Name>>& names,
                               const ProblemSpec& spec) {
  if (names) return expand_names(*names);
  OrderedJson all = OrderedJson::array();
  for (const PhaseSpec& phase : spec.phases)
    if (!phase.restitution) all.push_back(phase.name.value);
  return all;
}

OrderedJson expand_costs(const std::vector<CostSpec>& costs, const ProblemSpec& spec,
                         const Plant& plant, bool terminal) {
  OrderedJson json = OrderedJson::object();
  for (const CostSpec& cost : costs)
    json[cost.name.value] = expand_cost(cost, spec, plant, terminal);
  return json;
}

OrderedJson expand_constraints(const ProblemSpec& spec) {
  OrderedJson json = OrderedJson::object();
  for (const ControlBoundsSpec& constraint : spec.constraints) {
    OrderedJson entry = {{"bounds", "control"}};
    if (constraint.from_urdf) entry["from"] = "urdf";
    if (constraint.lower) entry["lower"] = expand_components(*constraint.lower);
    if (constraint.upper) entry["upper"] = expand_components(*constraint.upper);
    entry["phases"] = expand_phase_names(constraint.phases, spec);
    json[constraint.name.value] = std::move(entry);
  }
  return json;
}

}  // namespace conddp
