#pragma once

#include <optional>

#include "problem_file/model/spec_expression.hpp"
#include "problem_file/yaml/yaml_reader.hpp"
#include "systems/expressions/lexer.hpp"

namespace conddp {

/// The text of an expression: a scalar, or a list, which becomes a vector in brackets. Anything
/// else is reported.
std::optional<ExpressionText> read_expression(const YamlReader& reader);

/// The position in the file of a byte of an expression's text. Handles quotes, block scalars and
/// text on several lines.
Place place_in_expression(const ExpressionText& expression, int offset, const Diagnostics& sources);

/// Reports an error or warning about an expression at its position in the file.
void report_expression(const ExpressionText& expression, const ExpressionMessage& message,
                       Severity severity, Diagnostics& out);

}  // namespace conddp
