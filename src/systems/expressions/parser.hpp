#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "systems/expressions/lexer.hpp"
#include "systems/expressions/scope.hpp"

namespace conddp {

/// Limits of a single expression.
inline constexpr std::size_t kMostExpressionBytes = 20000;
inline constexpr int kMostExpressionNesting = 100;
/// Limit on a vector's size: names that refer to other vectors could double it many times.
inline constexpr std::size_t kMostVectorNumbers = 1000;
/// Limit on the shared graph; the parser reads no operand beyond it.
inline constexpr int kMostOperations = 1'000'000;

/// An expression read from text.
struct ParsedExpression {
  std::optional<ExpressionValue> value;  ///< empty after an error
  ExpressionMessage error;
  std::vector<ExpressionMessage> warnings;  ///< about non-smooth operations
};

/// Reads an expression into the graph, with the names of the scope:
///
///     a + b  a - b  a * b  a / b  -a   ^ binds closest and to the right: -a^b^c = -(a^(b^c))
///     f(a, b)  [a, b, c]  v[0]  v[part]  v.part
///     a < b  <=  >  >=  not  and  or   in the condition of if(condition, a, b)
///
/// Numbers are added to numbers, and vectors to vectors of the same size; numbers multiply and
/// divide vectors. A vector in brackets may concatenate vectors. A part in the brackets of v[part]
/// may contain any character except ']'.
ParsedExpression parse_expression(std::string_view text, const ExpressionScope& scope,
                                  ExpressionGraph& graph);

}  // namespace conddp
