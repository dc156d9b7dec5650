#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "spatial/scalar.hpp"
#include "systems/graphs/spline_table.hpp"

namespace conddp {

/// The operation of a node of an expression graph on its operands a, b, c.
enum class Operation : std::uint8_t {
  kConstant,
  kInput,
  kAdd,
  kSubtract,
  kMultiply,
  kNegate,
  kInverse,  ///< 1 / a
  kSqrt,
  kSin,
  kCos,
  kTan,
  kAsin,
  kAcos,
  kAtan,
  kAtan2,
  kSinh,
  kCosh,
  kTanh,
  kExp,
  kLog,
  kPower,
  kLess,       ///< 1 if a < b, else 0
  kLessEqual,  ///< 1 if a ≤ b, else 0
  kChoose,     ///< b if a is not 0, else c
  kTable,      ///< a table, or its derivative, at a or (a, b)
};

/// Index of a node. Operands have smaller indices.
using NodeId = std::int32_t;

struct ExpressionNode {
  Operation operation;
  NodeId a = -1, b = -1, c = -1;
  double constant = 0;       ///< of kConstant
  std::int32_t payload = 0;  ///< index of a kInput; table and orders of a kTable (TableUse)
};

/// The table that a kTable node reads, and the order of differentiation by each argument.
struct TableUse {
  int table;
  int by_x = 0;
  int by_y = 0;

  static TableUse of(std::int32_t payload) {
    return {payload >> 4, (payload >> 2) & 3, payload & 3};
  }
  std::int32_t payload() const { return table << 4 | by_x << 2 | by_y; }
};

/// Numbers computed from inputs, as a graph without duplicate computations. Factories return an
/// existing node if possible, fold constants, and omit operations without effect (x + 0, 1·x).
/// Products with zero are zero, whatever the value of the other factor.
class ExpressionGraph {
 public:
  using Tables = std::vector<std::shared_ptr<const SplineTable>>;

  int size() const { return static_cast<int>(nodes_.size()); }
  const ExpressionNode& operator[](NodeId id) const { return nodes_[id]; }
  /// The value of a constant node; empty for other nodes.
  std::optional<double> constant_of(NodeId id) const;
  bool is_constant(NodeId id, double value) const { return constant_of(id) == value; }
  const Tables& tables() const { return tables_; }

  NodeId constant(double value);
  NodeId input(int index);
  NodeId add(NodeId a, NodeId b);
  NodeId subtract(NodeId a, NodeId b);
  NodeId multiply(NodeId a, NodeId b);
  NodeId divide(NodeId a, NodeId b);
  NodeId negate(NodeId a);
  NodeId inverse(NodeId a);
  /// a to the power b: products for integers up to 64, a root for ±1/2.
  NodeId power(NodeId a, NodeId b);
  /// A function of one argument, kSqrt to kLog.
  NodeId function(Operation operation, NodeId a);
  NodeId atan2(NodeId y, NodeId x);
  NodeId less(NodeId a, NodeId b);
  NodeId less_equal(NodeId a, NodeId b);
  NodeId choose(NodeId condition, NodeId a, NodeId b);
  int add_table(std::shared_ptr<const SplineTable> table);
  /// b is ignored if the table has one argument.
  NodeId table(const TableUse& use, NodeId a, NodeId b);

  NodeId square(NodeId a) { return multiply(a, a); }

 private:
  /// The node with this content; adds it if it is new.
  NodeId intern(const ExpressionNode& node);
  NodeId fold(const ExpressionNode& node);
  NodeId integer_power(NodeId a, int exponent);
  /// A constant, which has a node, times another node. Empty if this needs a new product.
  std::optional<NodeId> scale(double factor, NodeId constant_node, NodeId other);

  struct Hash {
    std::size_t operator()(const ExpressionNode& node) const;
  };
  struct Same {
    bool operator()(const ExpressionNode& a, const ExpressionNode& b) const;
  };
  std::vector<ExpressionNode> nodes_;
  std::unordered_map<ExpressionNode, NodeId, Hash, Same> index_;
  Tables tables_;
};

/// Calls visit(operand) for the operands of a node.
template <class Visit>
void for_each_operand(const ExpressionNode& node, Visit&& visit) {
  for (const NodeId operand : {node.a, node.b, node.c})
    if (operand >= 0) visit(operand);
}

/// All nodes that the roots depend on, including the roots, ascending.
std::vector<NodeId> nodes_below(const ExpressionGraph& graph, std::span<const NodeId> roots);

/// A scalar that records its computation, turning formulas templated on the scalar into
/// expressions. A constant joins a graph when combined with a number that belongs to one.
class GraphNumber {
 public:
  GraphNumber(double constant = 0)  // NOLINT(google-explicit-constructor): a constant
      : constant_(constant) {}
  GraphNumber(ExpressionGraph& graph, NodeId node) : graph_(&graph), node_(node) {}

  /// Its node in the recorded graph.
  NodeId node(ExpressionGraph& graph) const { return graph_ ? node_ : graph.constant(constant_); }

  friend GraphNumber operator+(const GraphNumber& a, const GraphNumber& b) {
    return join<&ExpressionGraph::add>(a, b);
  }
  friend GraphNumber operator-(const GraphNumber& a, const GraphNumber& b) {
    return join<&ExpressionGraph::subtract>(a, b);
  }
  friend GraphNumber operator*(const GraphNumber& a, const GraphNumber& b) {
    return join<&ExpressionGraph::multiply>(a, b);
  }
  friend GraphNumber operator/(const GraphNumber& a, const GraphNumber& b) {
    return join<&ExpressionGraph::divide>(a, b);
  }
  friend GraphNumber operator-(const GraphNumber& a) { return GraphNumber(0.0) - a; }
  GraphNumber& operator+=(const GraphNumber& b) { return *this = *this + b; }
  GraphNumber& operator-=(const GraphNumber& b) { return *this = *this - b; }

  friend GraphNumber sin(const GraphNumber& a) { return apply(Operation::kSin, a); }
  friend GraphNumber cos(const GraphNumber& a) { return apply(Operation::kCos, a); }
  friend GraphNumber asin(const GraphNumber& a) { return apply(Operation::kAsin, a); }
  friend GraphNumber sqrt(const GraphNumber& a) { return apply(Operation::kSqrt, a); }
  friend void sincos(const GraphNumber& a, GraphNumber& s, GraphNumber& c) {
    const GraphNumber angle = a;
    s = sin(angle);
    c = cos(angle);
  }

 private:
  template <auto kJoin>
  static GraphNumber join(const GraphNumber& a, const GraphNumber& b) {
    ExpressionGraph* graph = a.graph_ ? a.graph_ : b.graph_;
    if (graph) return {*graph, (graph->*kJoin)(a.node(*graph), b.node(*graph))};
    ExpressionGraph constants;
    const NodeId value = (constants.*kJoin)(a.node(constants), b.node(constants));
    return GraphNumber(constants.constant_of(value).value());
  }
  static GraphNumber apply(Operation operation, const GraphNumber& a) {
    if (a.graph_) return {*a.graph_, a.graph_->function(operation, a.node_)};
    ExpressionGraph constants;
    const NodeId value = constants.function(operation, a.node(constants));
    return GraphNumber(constants.constant_of(value).value());
  }

  ExpressionGraph* graph_ = nullptr;
  NodeId node_ = -1;
  double constant_ = 0;  ///< used without a graph
};

template <>
inline constexpr bool kIsScalar<GraphNumber> = true;

}  // namespace conddp
