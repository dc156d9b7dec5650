#pragma once

#include <span>
#include <string>
#include <string_view>
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

/// The type that a function's argument must have.
enum class ArgumentKind {
  kNumber,
  kAboveZero,   ///< a number; above zero if constant
  kVector,      ///< of any size
  kSameVector,  ///< same size as the first argument
  kVector3,
  kQuaternion,  ///< a vector of 4, x y z w
  kCondition,
  kAny,   ///< a number or a vector
  kSame,  ///< same type as the preceding argument
};

/// A function of the expression language.
struct ExpressionFunction {
  struct Argument {
    std::string_view name;
    ArgumentKind kind;
  };
  std::string_view name;
  std::vector<Argument> arguments;
  std::string_view documentation;  ///< a clause with units
  /// Why the function is not smooth, for a warning; empty if it is smooth.
  std::string_view kink;
  ExpressionValue (*apply)(ExpressionGraph&, const std::vector<ExpressionValue>&);
};

/// All functions, by topic.
std::span<const ExpressionFunction> expression_functions();
/// Null if no function has this name.
const ExpressionFunction* find_expression_function(std::string_view name);

/// A named constant.
struct ExpressionConstant {
  std::string_view name;
  double value;
  std::string_view documentation;
};
std::span<const ExpressionConstant> expression_constants();
/// Null if no constant has this name.
const ExpressionConstant* find_expression_constant(std::string_view name);

/// The required type of an argument in messages: "a number", "a quaternion (vector of 4)".
std::string_view argument_kind_name(ArgumentKind kind);

}  // namespace conddp
