#include "output/schedule/softened_constraint.hpp"

#include <fmt/format.h>

namespace conddp {
namespace {

/// Weights of costs that replace constraints: during the motion, and at single nodes. With larger
/// weights, solvers without constraints hardly complete a stage.
constexpr double kRunningWeight = 100, kNodeWeight = 1000;

/// True if a cost on the same residual, or on the state, can express the constraint.
bool can_be_softened(const OrderedJson& constraint) {
  if (constraint.contains("bounds") &&
      (constraint["bounds"] == "control" || constraint.contains("from")))
    return false;
  if (constraint.value("cone", "") == "second_order") return false;
  return !constraint.contains("centers") && !constraint.contains("at_least") &&
         !constraint.contains("at_most");
}

bool is_zero(const OrderedJson& constraint) {
  const auto value = constraint.find("equals");
  return value != constraint.end() && value->is_number() && value->get<double>() == 0;
}

void move_to_costs(OrderedJson& constraints, OrderedJson& costs, double weight,
                   std::vector<std::string>& notes) {
  OrderedJson kept = OrderedJson::object();
  for (const auto& [key, constraint] : constraints.items()) {
    if (constraint.value("bounds", "") == "control") {
      kept[key] = constraint;
      continue;
    }
    OrderedJson cost = softened(constraint, key.ends_with("_landing") ? kNodeWeight : weight);
    if (cost.is_null())
      notes.push_back(fmt::format("the constraint '{}' is left out", key));
    else
      costs[key] = std::move(cost);
  }
  constraints = std::move(kept);
}

}  // namespace

OrderedJson softened(const OrderedJson& constraint, double weight) {
  if (!can_be_softened(constraint)) return nullptr;
  OrderedJson cost = constraint;
  if (constraint.contains("bounds")) {
    cost = {{"residual", "state"}};
    if (constraint.contains("phases")) cost["phases"] = constraint["phases"];
  }
  cost["weight"] = weight;
  for (const char* key : {"equals", "lower", "upper"}) cost.erase(key);
  if (is_zero(constraint) || constraint.value("residual", "") == "friction_cone") return cost;
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

void soften_constraints(OrderedJson& problem, std::vector<std::string>& notes) {
  move_to_costs(problem["constraints"], problem["costs"], kRunningWeight, notes);
  OrderedJson& terminal = problem["terminal"];
  move_to_costs(terminal["constraints"], terminal["costs"], kNodeWeight, notes);
}

}  // namespace conddp
