#pragma once

#include <optional>

#include "problem_file/spec/spec_expression.hpp"
#include "problem_file/yaml/yaml_reader.hpp"
#include "systems/expressions/lexer.hpp"

namespace conddp {

/// The text of an expression: a scalar, or a list, which is a vector in brackets. Reported
/// otherwise.
std::optional<ExpressionText> read_expression(const YamlReader& reader);

/// The place in the file of a byte of an expression's text: also behind quotes, in block scalars,
/// and where the text is on several lines.
Place place_in_expression(const ExpressionText& expression, int offset, const Diagnostics& sources);

/// Reports what is wrong with an expression, or what it warns of, where it stands in the file.
void report_expression(const ExpressionText& expression, const ExpressionMessage& message,
                       Severity severity, Diagnostics& out);

}  // namespace conddp
