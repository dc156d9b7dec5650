#pragma once

#include <string>
#include <vector>

#include "systems/graphs/graph.hpp"

namespace conddp {

/// The value of an expression or a name: a number, a vector of numbers, or a condition.
struct ExpressionValue {
  enum class Kind { kNumber, kVector, kCondition };
  /// A named part of a vector: some of its numbers, in order.
  struct Part {
    std::string name;
    int first;
    int count = 1;
  };

  Kind kind = Kind::kNumber;
  std::vector<NodeId> nodes;
  std::string unit;         ///< of a name with a unit, for messages
  std::vector<Part> parts;  ///< of a vector; empty: x y z w for up to four numbers

  static ExpressionValue number(NodeId node) { return {Kind::kNumber, {node}, {}, {}}; }
  static ExpressionValue vector(std::vector<NodeId> nodes) {
    return {Kind::kVector, std::move(nodes), {}, {}};
  }
  static ExpressionValue condition(NodeId node) { return {Kind::kCondition, {node}, {}, {}}; }

  bool is_number() const { return kind == Kind::kNumber; }
  int size() const { return static_cast<int>(nodes.size()); }
  bool has_type_of(const ExpressionValue& other) const {
    return kind == other.kind && size() == other.size();
  }
  /// The parts, with default names if they are not named.
  std::vector<Part> named_parts() const;
  /// A part as a value: a number, or a vector if it has several.
  ExpressionValue part(const Part& part) const;
  /// "number", "vector of 3", "condition"; with a unit if it has one: "number (m/s)".
  std::string type() const;
};

}  // namespace conddp
