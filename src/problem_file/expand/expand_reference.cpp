#include "problem_file/expand/expand_sections.hpp"

namespace conddp {
namespace {

OrderedJson expand_value(const ReferenceValueSpec& value, const ReferenceForm& form) {
  return value.name ? OrderedJson(value.name->value) : form.expand(value);
}

/// The default for a missing reference; null without a default.
OrderedJson expand_absent(const CostSpec& cost) {
  // Limits from the URDF are absolute and exclude a reference.
  if (cost.activation.from_urdf) return nullptr;
  const ReferenceForm& form = *cost.definition->reference;
  const auto zero = form.zero(cost, cost.residual.place);
  return zero ? form.expand(*zero) : OrderedJson(nullptr);
}

OrderedJson expand_way_points(const ReferenceSpec& spec, const ReferenceForm& form) {
  OrderedJson places = OrderedJson::array(), values = OrderedJson::array();
  for (const Located<double>& time : spec.times) places.push_back(time.value);
  for (const Located<int>& knot : spec.knots) places.push_back(knot.value);
  for (const ReferenceValueSpec& value : spec.values) values.push_back(expand_value(value, form));
  return {{spec.knots.empty() ? "times" : "knots", std::move(places)},
          {"values", std::move(values)}};
}

}  // namespace

OrderedJson expand_reference(const CostSpec& cost) {
  const ReferenceForm* form = cost.definition->reference;
  if (form == nullptr) return nullptr;
  if (!cost.reference) return expand_absent(cost);
  const ReferenceSpec& spec = *cost.reference;
  if (spec.file) return expand_data_file(*spec.file);
  if (spec.times.empty() && spec.knots.empty()) return expand_value(spec.values[0], *form);
  return expand_way_points(spec, *form);
}

}  // namespace conddp
