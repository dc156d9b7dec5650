#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "systems/expressions/value.hpp"

namespace conddp {

/// What an argument of a function has to be.
enum class ArgumentKind {
  kNumber,
  kAboveZero,   ///< a number, above zero where it is constant
  kVector,      ///< of any size
  kSameVector,  ///< of the size of the first argument
  kVector3,
  kQuaternion,  ///< a vector of 4, x y z w
  kCondition,
  kAny,   ///< a number or a vector
  kSame,  ///< of the type of the argument before
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
  /// What is not smooth about it, for a warning; empty where nothing is.
  std::string_view kink;
  ExpressionValue (*apply)(ExpressionGraph&, const std::vector<ExpressionValue>&);
};

/// All functions, by topic.
std::span<const ExpressionFunction> expression_functions();
/// Null where there is none of that name.
const ExpressionFunction* find_expression_function(std::string_view name);

/// A named constant.
struct ExpressionConstant {
  std::string_view name;
  double value;
  std::string_view documentation;
};
std::span<const ExpressionConstant> expression_constants();
/// Null where there is none of that name.
const ExpressionConstant* find_expression_constant(std::string_view name);

/// "a number", "a quaternion (vector of 4)": how messages call what an argument has to be.
std::string_view argument_kind_name(ArgumentKind kind);

}  // namespace conddp
