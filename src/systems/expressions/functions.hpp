#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "systems/expressions/value.hpp"

namespace conddp {

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
