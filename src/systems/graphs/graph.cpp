#include "systems/graphs/graph.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <utility>

namespace conddp {
namespace {

/// The function that an operation computes from its operands.
using Formula = double (*)(double a, double b, double c);

constexpr std::pair<Operation, Formula> kFormulas[] = {
    {Operation::kAdd, [](double a, double b, double) { return a + b; }},
    {Operation::kSubtract, [](double a, double b, double) { return a - b; }},
    {Operation::kMultiply, [](double a, double b, double) { return a * b; }},
    {Operation::kNegate, [](double a, double, double) { return -a; }},
    {Operation::kInverse, [](double a, double, double) { return 1 / a; }},
    {Operation::kSqrt, [](double a, double, double) { return std::sqrt(a); }},
    {Operation::kSin, [](double a, double, double) { return std::sin(a); }},
    {Operation::kCos, [](double a, double, double) { return std::cos(a); }},
    {Operation::kTan, [](double a, double, double) { return std::tan(a); }},
    {Operation::kAsin, [](double a, double, double) { return std::asin(a); }},
    {Operation::kAcos, [](double a, double, double) { return std::acos(a); }},
    {Operation::kAtan, [](double a, double, double) { return std::atan(a); }},
    {Operation::kAtan2, [](double a, double b, double) { return std::atan2(a, b); }},
    {Operation::kSinh, [](double a, double, double) { return std::sinh(a); }},
    {Operation::kCosh, [](double a, double, double) { return std::cosh(a); }},
    {Operation::kTanh, [](double a, double, double) { return std::tanh(a); }},
    {Operation::kExp, [](double a, double, double) { return std::exp(a); }},
    {Operation::kLog, [](double a, double, double) { return std::log(a); }},
    {Operation::kPower, [](double a, double b, double) { return std::pow(a, b); }},
    {Operation::kLess, [](double a, double b, double) { return a < b ? 1.0 : 0.0; }},
    {Operation::kLessEqual, [](double a, double b, double) { return a <= b ? 1.0 : 0.0; }},
    {Operation::kChoose, [](double a, double b, double c) { return a != 0 ? b : c; }}};

/// A node's value if all of its operands are constants.
double value_of_constants(const ExpressionNode& node, double a, double b, double c,
                          const ExpressionGraph::Tables& tables) {
  if (node.operation == Operation::kTable) {
    const TableUse use = TableUse::of(node.payload);
    return tables[use.table]->derivative(use.by_x, use.by_y, a, b);
  }
  const auto found = std::find_if(std::begin(kFormulas), std::end(kFormulas),
                                  [&](const auto& entry) { return entry.first == node.operation; });
  return found != std::end(kFormulas) ? found->second(a, b, c) : node.constant;
}

}  // namespace

std::size_t ExpressionGraph::Hash::operator()(const ExpressionNode& node) const {
  std::uint64_t hash = std::bit_cast<std::uint64_t>(node.constant);
  for (const std::int64_t part : {std::int64_t{node.a}, std::int64_t{node.b}, std::int64_t{node.c},
                                  std::int64_t{node.payload}, std::int64_t(node.operation)}) {
    hash ^= static_cast<std::uint64_t>(part) + 0x9e3779b97f4a7c15 + (hash << 6) + (hash >> 2);
    hash *= 0xff51afd7ed558ccd;
  }
  return hash ^ (hash >> 32);
}

bool ExpressionGraph::Same::operator()(const ExpressionNode& a, const ExpressionNode& b) const {
  return a.operation == b.operation && a.a == b.a && a.b == b.b && a.c == b.c &&
         a.payload == b.payload &&
         std::bit_cast<std::uint64_t>(a.constant) == std::bit_cast<std::uint64_t>(b.constant);
}

std::optional<double> ExpressionGraph::constant_of(NodeId id) const {
  if (nodes_[id].operation != Operation::kConstant) return std::nullopt;
  return nodes_[id].constant;
}

NodeId ExpressionGraph::intern(const ExpressionNode& node) {
  const auto [place, is_new] = index_.try_emplace(node, size());
  if (is_new) nodes_.push_back(node);
  return place->second;
}

NodeId ExpressionGraph::fold(const ExpressionNode& node) {
  double values[3] = {0, 0, 0};
  int i = 0;
  for (const NodeId operand : {node.a, node.b, node.c}) {
    if (operand >= 0) {
      const auto value = constant_of(operand);
      if (!value) return intern(node);
      values[i] = *value;
    }
    ++i;
  }
  return constant(value_of_constants(node, values[0], values[1], values[2], tables_));
}

NodeId ExpressionGraph::constant(double value) {
  return intern({.operation = Operation::kConstant, .constant = value == 0 ? 0.0 : value});
}

NodeId ExpressionGraph::input(int index) {
  return intern({.operation = Operation::kInput, .payload = index});
}

NodeId ExpressionGraph::add(NodeId a, NodeId b) {
  if (a > b) std::swap(a, b);
  if (is_constant(a, 0)) return b;
  if (is_constant(b, 0)) return a;
  if (nodes_[b].operation == Operation::kNegate) return subtract(a, nodes_[b].a);
  if (nodes_[a].operation == Operation::kNegate) return subtract(b, nodes_[a].a);
  return fold({Operation::kAdd, a, b});
}

NodeId ExpressionGraph::subtract(NodeId a, NodeId b) {
  if (a == b) return constant(0);
  if (is_constant(b, 0)) return a;
  if (is_constant(a, 0)) return negate(b);
  if (nodes_[b].operation == Operation::kNegate) return add(a, nodes_[b].a);
  if (nodes_[a].operation == Operation::kNegate) return negate(add(nodes_[a].a, b));
  return fold({Operation::kSubtract, a, b});
}

NodeId ExpressionGraph::multiply(NodeId a, NodeId b) {
  // The constant comes first.
  if (constant_of(b) || (!constant_of(a) && a > b)) std::swap(a, b);
  if (const auto factor = constant_of(a))
    if (const auto scaled = scale(*factor, a, b)) return *scaled;
  if (nodes_[a].operation == Operation::kNegate) return negate(multiply(nodes_[a].a, b));
  if (nodes_[b].operation == Operation::kNegate) return negate(multiply(a, nodes_[b].a));
  return fold({Operation::kMultiply, a, b});
}

std::optional<NodeId> ExpressionGraph::scale(double factor, NodeId constant_node, NodeId other) {
  if (factor == 0) return constant_node;
  if (factor == 1) return other;
  if (factor == -1) return negate(other);
  const ExpressionNode node = nodes_[other];  // the graph grows
  if (node.operation == Operation::kNegate) return multiply(constant(-factor), node.a);
  if (node.operation != Operation::kMultiply) return std::nullopt;
  const auto inner = constant_of(node.a);
  if (!inner) return std::nullopt;
  return multiply(constant(factor * *inner), node.b);
}

NodeId ExpressionGraph::divide(NodeId a, NodeId b) {
  const auto numerator = constant_of(a), denominator = constant_of(b);
  if (numerator && denominator) return constant(*numerator / *denominator);
  return multiply(a, inverse(b));
}

NodeId ExpressionGraph::negate(NodeId a) {
  const ExpressionNode& node = nodes_[a];
  if (node.operation == Operation::kNegate) return node.a;
  if (node.operation == Operation::kSubtract) return subtract(node.b, node.a);
  if (node.operation == Operation::kMultiply)
    if (const auto factor = constant_of(node.a)) {
      const NodeId rest = node.b;
      return multiply(constant(-*factor), rest);
    }
  return fold({Operation::kNegate, a});
}

NodeId ExpressionGraph::inverse(NodeId a) {
  const ExpressionNode& node = nodes_[a];
  if (node.operation == Operation::kInverse) return node.a;
  if (node.operation == Operation::kNegate) return negate(inverse(node.a));
  if (node.operation == Operation::kMultiply)
    if (const auto factor = constant_of(node.a)) {
      const NodeId rest = node.b;
      return multiply(constant(1 / *factor), inverse(rest));
    }
  return fold({Operation::kInverse, a});
}

NodeId ExpressionGraph::integer_power(NodeId a, int exponent) {
  NodeId result = constant(1);
  for (NodeId square_of_a = a; exponent > 0; exponent /= 2) {
    if (exponent % 2 == 1) result = multiply(result, square_of_a);
    if (exponent > 1) square_of_a = square(square_of_a);
  }
  return result;
}

NodeId ExpressionGraph::power(NodeId a, NodeId b) {
  constexpr double kLargest = 64;
  const auto exponent = constant_of(b);
  if (!exponent || constant_of(a) || std::abs(*exponent) > kLargest)
    return fold({Operation::kPower, a, b});
  const double size = std::abs(*exponent);
  // Other half-integer powers are not written as products with a root, whose derivative is infinite
  // at 0 while that of the power is finite.
  const bool is_root = size == 0.5, is_integer = size == std::floor(size);
  if (is_integer && size > 1 && nodes_[a].operation == Operation::kSqrt) {
    const NodeId radicand = nodes_[a].a;
    return power(radicand, constant(*exponent / 2));
  }
  if (!is_root && !is_integer) return fold({Operation::kPower, a, b});
  const NodeId result =
      is_root ? function(Operation::kSqrt, a) : integer_power(a, static_cast<int>(size));
  return *exponent < 0 ? inverse(result) : result;
}

NodeId ExpressionGraph::function(Operation operation, NodeId a) { return fold({operation, a}); }

NodeId ExpressionGraph::atan2(NodeId y, NodeId x) { return fold({Operation::kAtan2, y, x}); }

NodeId ExpressionGraph::less(NodeId a, NodeId b) { return fold({Operation::kLess, a, b}); }

NodeId ExpressionGraph::less_equal(NodeId a, NodeId b) {
  return fold({Operation::kLessEqual, a, b});
}

NodeId ExpressionGraph::choose(NodeId condition, NodeId a, NodeId b) {
  if (a == b) return a;
  if (const auto value = constant_of(condition)) return *value != 0 ? a : b;
  return fold({Operation::kChoose, condition, a, b});
}

int ExpressionGraph::add_table(std::shared_ptr<const SplineTable> table) {
  tables_.push_back(std::move(table));
  return static_cast<int>(tables_.size()) - 1;
}

NodeId ExpressionGraph::table(const TableUse& use, NodeId a, NodeId b) {
  constexpr int kCubic = 3;
  const bool plain = tables_[use.table]->arguments() == 1;
  if (use.by_x > kCubic || use.by_y > kCubic) return constant(0);
  return fold(
      {.operation = Operation::kTable, .a = a, .b = plain ? -1 : b, .payload = use.payload()});
}

std::vector<NodeId> nodes_below(const ExpressionGraph& graph, std::span<const NodeId> roots) {
  std::vector<NodeId> found, open(roots.begin(), roots.end());
  std::vector<bool> seen(graph.size(), false);
  while (!open.empty()) {
    const NodeId id = open.back();
    open.pop_back();
    if (seen[id]) continue;
    seen[id] = true;
    found.push_back(id);
    for_each_operand(graph[id], [&](NodeId operand) { open.push_back(operand); });
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace conddp
