#pragma once

#include "spatial/scalar.hpp"
#include "systems/graphs/graph.hpp"

namespace conddp {

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
