#include "systems/expressions/value.hpp"

#include <fmt/format.h>

namespace conddp {

std::vector<ExpressionValue::Part> ExpressionValue::named_parts() const {
  if (!parts.empty() || kind != Kind::kVector || size() > 4) return parts;
  std::vector<Part> named;
  for (int i = 0; i < size(); ++i) named.push_back({std::string(1, "xyzw"[i]), i});
  return named;
}

ExpressionValue ExpressionValue::part(const Part& part) const {
  const auto first = nodes.begin() + part.first;
  ExpressionValue value =
      part.count == 1 ? number(*first) : vector(std::vector<NodeId>(first, first + part.count));
  value.unit = unit;
  return value;
}

std::string ExpressionValue::type() const {
  const std::string of_unit = unit.empty() ? "" : fmt::format(" ({})", unit);
  switch (kind) {
    case Kind::kNumber:
      return "number" + of_unit;
    case Kind::kVector:
      return fmt::format("vector of {}{}", size(), of_unit);
    case Kind::kCondition:
      break;
  }
  return "condition";
}

}  // namespace conddp
