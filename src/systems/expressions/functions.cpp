#include "systems/expressions/functions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "spatial/so3.hpp"

namespace conddp {
namespace {

using Values = std::vector<ExpressionValue>;
using Graph = ExpressionGraph;
using Kind = ArgumentKind;

template <Operation kOperation>
ExpressionValue elementary(Graph& g, const Values& a) {
  return ExpressionValue::number(g.function(kOperation, a[0].nodes[0]));
}

NodeId dot(Graph& g, const std::vector<NodeId>& a, const std::vector<NodeId>& b) {
  NodeId sum = g.multiply(a[0], b[0]);
  for (std::size_t i = 1; i < a.size(); ++i) sum = g.add(sum, g.multiply(a[i], b[i]));
  return sum;
}

NodeId root(Graph& g, NodeId a) { return g.function(Operation::kSqrt, a); }

/// √(a + width²).
NodeId rounded_root(Graph& g, NodeId a, NodeId width) { return root(g, g.add(a, g.square(width))); }

/// Half of the sum plus or minus half of the smoothed absolute difference.
ExpressionValue smooth_extremum(Graph& g, const Values& v, bool largest) {
  const NodeId a = v[0].nodes[0], b = v[1].nodes[0], half = g.constant(0.5);
  const NodeId gap = rounded_root(g, g.square(g.subtract(a, b)), v[2].nodes[0]);
  const NodeId sum = g.add(a, b);
  return ExpressionValue::number(
      g.multiply(half, largest ? g.add(sum, gap) : g.subtract(sum, gap)));
}

/// A number of a graph with operators, so that formulas of the kernel can be recorded in graphs.
struct GraphNumber {
  Graph* graph;
  NodeId node;

  friend GraphNumber operator+(GraphNumber a, GraphNumber b) {
    return {a.graph, a.graph->add(a.node, b.node)};
  }
  friend GraphNumber operator-(GraphNumber a, GraphNumber b) {
    return {a.graph, a.graph->subtract(a.node, b.node)};
  }
  friend GraphNumber operator*(GraphNumber a, GraphNumber b) {
    return {a.graph, a.graph->multiply(a.node, b.node)};
  }
  friend GraphNumber operator-(GraphNumber a) { return {a.graph, a.graph->negate(a.node)}; }
};

GraphNumber number(Graph& g, const ExpressionValue& a, int i) { return {&g, a.nodes[i]}; }
Vector3<GraphNumber> vector3(Graph& g, const ExpressionValue& a) {
  return {number(g, a, 0), number(g, a, 1), number(g, a, 2)};
}
Quaternion<GraphNumber> quaternion(Graph& g, const ExpressionValue& a) {
  return {number(g, a, 0), number(g, a, 1), number(g, a, 2), number(g, a, 3)};
}
ExpressionValue value(const Vector3<GraphNumber>& a) {
  return ExpressionValue::vector({a.x.node, a.y.node, a.z.node});
}
ExpressionValue value(const Quaternion<GraphNumber>& a) {
  return ExpressionValue::vector({a.x.node, a.y.node, a.z.node, a.w.node});
}

/// Rotates a vector by a unit quaternion or its inverse.
ExpressionValue turned(Graph& g, const Values& v, bool back) {
  const Quaternion<GraphNumber> q = quaternion(g, v[0]);
  const Vector3<GraphNumber> a = vector3(g, v[1]);
  const GraphNumber one{&g, g.constant(1)};
  const GraphNumber x2 = q.x + q.x, y2 = q.y + q.y, z2 = q.z + q.z;
  const GraphNumber xx = q.x * x2, yy = q.y * y2, zz = q.z * z2;
  const GraphNumber xy = q.x * y2, xz = q.x * z2, yz = q.y * z2;
  const GraphNumber wx = q.w * x2, wy = q.w * y2, wz = q.w * z2;
  const GraphNumber r[3][3] = {{one - yy - zz, xy - wz, xz + wy},
                               {xy + wz, one - xx - zz, yz - wx},
                               {xz - wy, yz + wx, one - xx - yy}};
  const auto row = [&](int i) {
    const auto entry = [&](int j) { return back ? r[j][i] : r[i][j]; };
    return entry(0) * a.x + entry(1) * a.y + entry(2) * a.z;
  };
  return value(Vector3<GraphNumber>{row(0), row(1), row(2)});
}

ExpressionValue choice(Graph& g, NodeId condition, const ExpressionValue& a,
                       const ExpressionValue& b) {
  ExpressionValue chosen{a.kind, {}, {}, {}};
  for (int i = 0; i < a.size(); ++i)
    chosen.nodes.push_back(g.choose(condition, a.nodes[i], b.nodes[i]));
  return chosen;
}

const std::vector<ExpressionFunction>& function_table() {
  static const std::vector<ExpressionFunction> table = {
      {"sin", {{"a", Kind::kNumber}}, "sine of an angle in rad", "", elementary<Operation::kSin>},
      {"cos", {{"a", Kind::kNumber}}, "cosine of an angle in rad", "", elementary<Operation::kCos>},
      {"tan",
       {{"a", Kind::kNumber}},
       "tangent of an angle in rad",
       "",
       elementary<Operation::kTan>},
      {"asin", {{"a", Kind::kNumber}}, "arc sine, rad", "", elementary<Operation::kAsin>},
      {"acos", {{"a", Kind::kNumber}}, "arc cosine, rad", "", elementary<Operation::kAcos>},
      {"atan", {{"a", Kind::kNumber}}, "arc tangent, rad", "", elementary<Operation::kAtan>},
      {"atan2",
       {{"y", Kind::kNumber}, {"x", Kind::kNumber}},
       "direction of the point (x, y), rad, from -pi to pi",
       "",
       [](Graph& g, const Values& v) {
         return ExpressionValue::number(g.atan2(v[0].nodes[0], v[1].nodes[0]));
       }},
      {"sinh", {{"a", Kind::kNumber}}, "hyperbolic sine", "", elementary<Operation::kSinh>},
      {"cosh", {{"a", Kind::kNumber}}, "hyperbolic cosine", "", elementary<Operation::kCosh>},
      {"tanh", {{"a", Kind::kNumber}}, "hyperbolic tangent", "", elementary<Operation::kTanh>},
      {"exp", {{"a", Kind::kNumber}}, "exponential function", "", elementary<Operation::kExp>},
      {"log", {{"a", Kind::kNumber}}, "natural logarithm", "", elementary<Operation::kLog>},
      {"log10",
       {{"a", Kind::kNumber}},
       "logarithm to base 10",
       "",
       [](Graph& g, const Values& v) {
         return ExpressionValue::number(g.multiply(g.constant(1 / std::numbers::ln10),
                                                   g.function(Operation::kLog, v[0].nodes[0])));
       }},
      {"sqrt", {{"a", Kind::kNumber}}, "square root", "", elementary<Operation::kSqrt>},
      {"pow",
       {{"a", Kind::kNumber}, {"b", Kind::kNumber}},
       "a^b",
       "",
       [](Graph& g, const Values& v) {
         return ExpressionValue::number(g.power(v[0].nodes[0], v[1].nodes[0]));
       }},
      {"hypot",
       {{"a", Kind::kNumber}, {"b", Kind::kNumber}},
       "square root of a^2 + b^2",
       "",
       [](Graph& g, const Values& v) {
         return ExpressionValue::number(
             root(g, g.add(g.square(v[0].nodes[0]), g.square(v[1].nodes[0]))));
       }},
      {"smooth_abs",
       {{"a", Kind::kNumber}, {"width", Kind::kAboveZero}},
       "absolute value, rounded: square root of a^2 + width^2",
       "",
       [](Graph& g, const Values& v) {
         return ExpressionValue::number(rounded_root(g, g.square(v[0].nodes[0]), v[1].nodes[0]));
       }},
      {"smooth_min",
       {{"a", Kind::kNumber}, {"b", Kind::kNumber}, {"width", Kind::kAboveZero}},
       "smaller number, rounded: (a + b - smooth_abs(a - b, width))/2",
       "",
       [](Graph& g, const Values& v) { return smooth_extremum(g, v, false); }},
      {"smooth_max",
       {{"a", Kind::kNumber}, {"b", Kind::kNumber}, {"width", Kind::kAboveZero}},
       "larger number, rounded: (a + b + smooth_abs(a - b, width))/2",
       "",
       [](Graph& g, const Values& v) { return smooth_extremum(g, v, true); }},
      {"smooth_step",
       {{"a", Kind::kNumber}, {"width", Kind::kAboveZero}},
       "0 below and 1 above a = 0: (1 + tanh(a/width))/2",
       "",
       [](Graph& g, const Values& v) {
         const NodeId ratio = g.divide(v[0].nodes[0], v[1].nodes[0]);
         return ExpressionValue::number(g.multiply(
             g.constant(0.5), g.add(g.constant(1), g.function(Operation::kTanh, ratio))));
       }},
      {"smooth_norm",
       {{"v", Kind::kVector}, {"width", Kind::kAboveZero}},
       "length of a vector, rounded: square root of dot(v, v) + width^2",
       "",
       [](Graph& g, const Values& v) {
         return ExpressionValue::number(
             rounded_root(g, dot(g, v[0].nodes, v[0].nodes), v[1].nodes[0]));
       }},
      {"abs",
       {{"a", Kind::kNumber}},
       "absolute value",
       "has a kink at 0; smooth_abs has none",
       [](Graph& g, const Values& v) {
         const NodeId a = v[0].nodes[0];
         return ExpressionValue::number(g.choose(g.less(a, g.constant(0)), g.negate(a), a));
       }},
      {"sign",
       {{"a", Kind::kNumber}},
       "-1, 0 or 1",
       "jumps at 0; 2*smooth_step - 1 does not",
       [](Graph& g, const Values& v) {
         const NodeId a = v[0].nodes[0], zero = g.constant(0);
         return ExpressionValue::number(g.choose(g.less(a, zero), g.constant(-1),
                                                 g.choose(g.less(zero, a), g.constant(1), zero)));
       }},
      {"min",
       {{"a", Kind::kNumber}, {"b", Kind::kNumber}},
       "smaller number",
       "has a kink where both are equal; smooth_min has none",
       [](Graph& g, const Values& v) {
         const NodeId a = v[0].nodes[0], b = v[1].nodes[0];
         return ExpressionValue::number(g.choose(g.less(b, a), b, a));
       }},
      {"max",
       {{"a", Kind::kNumber}, {"b", Kind::kNumber}},
       "larger number",
       "has a kink where both are equal; smooth_max has none",
       [](Graph& g, const Values& v) {
         const NodeId a = v[0].nodes[0], b = v[1].nodes[0];
         return ExpressionValue::number(g.choose(g.less(a, b), b, a));
       }},
      {"if",
       {{"condition", Kind::kCondition}, {"a", Kind::kAny}, {"b", Kind::kSame}},
       "a where the condition holds, else b",
       "is not smooth where its condition changes; smooth_step makes a transition that is",
       [](Graph& g, const Values& v) { return choice(g, v[0].nodes[0], v[1], v[2]); }},
      {"norm",
       {{"v", Kind::kVector}},
       "length of a vector, not differentiable at 0 (smooth_norm is)",
       "",
       [](Graph& g, const Values& v) {
         return ExpressionValue::number(root(g, dot(g, v[0].nodes, v[0].nodes)));
       }},
      {"dot",
       {{"a", Kind::kVector}, {"b", Kind::kSameVector}},
       "scalar product",
       "",
       [](Graph& g, const Values& v) {
         return ExpressionValue::number(dot(g, v[0].nodes, v[1].nodes));
       }},
      {"cross",
       {{"a", Kind::kVector3}, {"b", Kind::kVector3}},
       "vector product",
       "",
       [](Graph& g, const Values& v) { return value(cross(vector3(g, v[0]), vector3(g, v[1]))); }},
      {"rotate",
       {{"q", Kind::kQuaternion}, {"v", Kind::kVector3}},
       "v turned by the unit quaternion q: from body axes to the world",
       "",
       [](Graph& g, const Values& v) { return turned(g, v, false); }},
      {"rotate_inverse",
       {{"q", Kind::kQuaternion}, {"v", Kind::kVector3}},
       "v turned back by the unit quaternion q: from the world to body axes",
       "",
       [](Graph& g, const Values& v) { return turned(g, v, true); }},
      {"quaternion_product",
       {{"p", Kind::kQuaternion}, {"q", Kind::kQuaternion}},
       "the rotation q followed by p",
       "",
       [](Graph& g, const Values& v) { return value(quaternion(g, v[0]) * quaternion(g, v[1])); }},
      {"conjugate",
       {{"q", Kind::kQuaternion}},
       "the inverse rotation of a unit quaternion",
       "",
       [](Graph& g, const Values& v) { return value(conjugate(quaternion(g, v[0]))); }},
  };
  return table;
}

constexpr std::array kConstants = {
    ExpressionConstant{"pi", std::numbers::pi, "circumference by diameter of a circle"}};

}  // namespace

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

std::span<const ExpressionFunction> expression_functions() { return function_table(); }

const ExpressionFunction* find_expression_function(std::string_view name) {
  const auto& table = function_table();
  const auto found = std::find_if(table.begin(), table.end(),
                                  [&](const ExpressionFunction& f) { return f.name == name; });
  return found == table.end() ? nullptr : &*found;
}

std::span<const ExpressionConstant> expression_constants() { return kConstants; }

const ExpressionConstant* find_expression_constant(std::string_view name) {
  const auto* found = std::find_if(std::begin(kConstants), std::end(kConstants),
                                   [&](const ExpressionConstant& c) { return c.name == name; });
  return found == std::end(kConstants) ? nullptr : found;
}

std::string_view argument_kind_name(ArgumentKind kind) {
  switch (kind) {
    case ArgumentKind::kNumber:
      return "a number";
    case ArgumentKind::kAboveZero:
      return "a positive number";
    case ArgumentKind::kVector:
    case ArgumentKind::kSameVector:
      return "a vector";
    case ArgumentKind::kVector3:
      return "a vector of 3";
    case ArgumentKind::kQuaternion:
      return "a quaternion (vector of 4)";
    case ArgumentKind::kCondition:
      return "a condition";
    case ArgumentKind::kAny:
    case ArgumentKind::kSame:
      break;
  }
  return "a number or a vector";
}

}  // namespace conddp
