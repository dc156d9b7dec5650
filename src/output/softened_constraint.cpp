#include "output/softened_constraint.hpp"

namespace conddp {

OrderedJson softened(const OrderedJson& constraint, double weight) {
  OrderedJson cost = constraint;
  if (constraint.contains("bounds")) {
    if (constraint["bounds"] == "control" || constraint.contains("from")) return nullptr;
    cost = {{"residual", "state"}};
    if (constraint.contains("phases")) cost["phases"] = constraint["phases"];
  }
  if (constraint.contains("centers") || constraint.contains("at_least") ||
      constraint.contains("at_most") || constraint.value("cone", "") == "second_order")
    return nullptr;
  cost["weight"] = weight;
  const bool zero = constraint.contains("equals") && constraint["equals"].is_number() &&
                    constraint["equals"].get<double>() == 0;
  for (const char* key : {"equals", "lower", "upper"}) cost.erase(key);
  if (zero || constraint.value("residual", "") == "friction_cone") return cost;
  OrderedJson activation = {{"kind", "quadratic_barrier"}};
  const auto bound = [&](const char* from, const char* to) {
    if (constraint.contains(from)) activation[to] = constraint[from];
  };
  bound("equals", "lower");
  bound("equals", "upper");
  bound("lower", "lower");
  bound("upper", "upper");
  cost["activation"] = std::move(activation);
  return cost;
}

}  // namespace conddp
