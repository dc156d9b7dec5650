#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "systems/expressions/lexer.hpp"
#include "systems/expressions/scope.hpp"

namespace conddp {

/// Limits of one expression.
inline constexpr std::size_t kMostExpressionBytes = 20000;
inline constexpr int kMostExpressionNesting = 100;
/// Of a vector: what a name is in another one, and so on, would double many times.
inline constexpr std::size_t kMostVectorNumbers = 1000;
/// Of the graph that expressions share, beyond which no further operand is read.
inline constexpr int kMostOperations = 1'000'000;

/// An expression read from text.
struct ParsedExpression {
  std::optional<ExpressionValue> value;  ///< empty where there is an error
  ExpressionMessage error;
  std::vector<ExpressionMessage> warnings;  ///< of what is not smooth
};

/// Reads an expression into the graph, with the names of the scope:
///
///     a + b  a - b  a * b  a / b  -a   ^ binds closest and to the right: -a^b^c = -(a^(b^c))
///     f(a, b)  [a, b, c]  v[0]  v[part]  v.part
///     a < b  <=  >  >=  not  and  or   in the condition of if(condition, a, b)
///
/// Numbers are added to numbers, and vectors to vectors of the same size; numbers multiply and
/// divide vectors. A vector in brackets may be made of vectors, one after the other. Between the
/// brackets of v[part] a part may have any characters but ']'.
ParsedExpression parse_expression(std::string_view text, const ExpressionScope& scope,
                                  ExpressionGraph& graph);

}  // namespace conddp
