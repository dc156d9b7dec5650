#include "problem_file/expand/expand_sections.hpp"

namespace conddp {
namespace {

OrderedJson expand_value(const ReferenceValueSpec& value, ResidualKind kind) {
  if (value.name) return OrderedJson(value.name->value);
  if (value.components) return expand_components(*value.components);
  if (value.state) return expand_state(*value.state);
  if (value.twist) return expand_twist(*value.twist);
  const bool point = kind == ResidualKind::kFramePosition || kind == ResidualKind::kComPosition;
  return point ? expand_vector(*value.pose->position) : expand_pose(*value.pose);
}

/// What a cost without a reference is measured from.
OrderedJson neutral_reference(const CostSpec& cost) {
  switch (cost.kind) {
    case ResidualKind::kState:
      return cost.columns ? OrderedJson(0.0) : OrderedJson::object();
    case ResidualKind::kControl:
    case ResidualKind::kJointPosition:
    case ResidualKind::kJointVelocity:
    case ResidualKind::kJointAcceleration:
    case ResidualKind::kCentroidalMomentum:
    case ResidualKind::kContactForce:
      return OrderedJson(0.0);
    case ResidualKind::kFrameVelocity:
      return expand_twist({});
    case ResidualKind::kFramePosition:
    case ResidualKind::kComPosition:
      return expand_vector(Vector3<double>::zero());
    case ResidualKind::kFrameRotation:
    case ResidualKind::kFramePlacement:
    case ResidualKind::kControlRate:
    case ResidualKind::kControlGravity:
    case ResidualKind::kFrictionCone:
    case ResidualKind::kWrenchCone:
    case ResidualKind::kCenterOfPressure:
    case ResidualKind::kDistance:
    case ResidualKind::kContactVelocity:
    case ResidualKind::kCycle:
    case ResidualKind::kCombination:
      break;
  }
  return nullptr;
}

}  // namespace

OrderedJson expand_reference(const CostSpec& cost) {
  if (!cost.reference) {
    // Limits from the URDF are absolute and exclude a reference.
    return cost.activation.from_urdf ? OrderedJson(nullptr) : neutral_reference(cost);
  }
  const ReferenceSpec& spec = *cost.reference;
  if (spec.file) return expand_data_file(*spec.file);
  if (spec.times.empty() && spec.knots.empty()) return expand_value(spec.values[0], cost.kind);
  OrderedJson places = OrderedJson::array(), values = OrderedJson::array();
  for (const Located<double>& time : spec.times) places.push_back(time.value);
  for (const Located<int>& knot : spec.knots) places.push_back(knot.value);
  for (const ReferenceValueSpec& value : spec.values)
    values.push_back(expand_value(value, cost.kind));
  return {{spec.knots.empty() ? "times" : "knots", std::move(places)},
          {"values", std::move(values)}};
}

}  // namespace conddp
