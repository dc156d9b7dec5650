#include "problem_file/expand/expand_sections.hpp"

namespace conddp {
namespace {

OrderedJson expand_value(const ReferenceValueSpec& value, const ReferenceForm& form) {
  return value.name ? OrderedJson(value.name->value) : form.expand(value);
}

}  // namespace

OrderedJson expand_reference(const CostSpec& cost) {
  const ReferenceForm* form = cost.definition->reference;
  if (form == nullptr) return nullptr;
  if (!cost.reference) {
    // Limits from the URDF are absolute and exclude a reference.
    if (cost.activation.from_urdf) return nullptr;
    const auto zero = form->zero(cost, cost.residual.place);
    return zero ? form->expand(*zero) : OrderedJson(nullptr);
  }
  const ReferenceSpec& spec = *cost.reference;
  if (spec.file) return expand_data_file(*spec.file);
  if (spec.times.empty() && spec.knots.empty()) return expand_value(spec.values[0], *form);
  OrderedJson places = OrderedJson::array(), values = OrderedJson::array();
  for (const Located<double>& time : spec.times) places.push_back(time.value);
  for (const Located<int>& knot : spec.knots) places.push_back(knot.value);
  for (const ReferenceValueSpec& value : spec.values) values.push_back(expand_value(value, *form));
  return {{spec.knots.empty() ? "times" : "knots", std::move(places)},
          {"values", std::move(values)}};
}

}  // namespace conddp
