#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "problem_file/yaml/yaml_reader.hpp"
#include "systems/expressions/lexer.hpp"

namespace conddp {

/// The text of an expression: a scalar, or a list, which is a vector in brackets. Reported
/// otherwise.
std::optional<std::string> read_expression(const YamlReader& reader);

/// The place in the file of a byte of an expression's text that `read_expression` has read: also
/// behind quotes, in block scalars, and where the text is on several lines.
Place place_in_expression(const YamlReader& reader, std::string_view text, int offset);

/// Reports what is wrong with an expression, or what it warns of, where it stands in the file.
void report_expression(const YamlReader& reader, std::string_view text,
                       const ExpressionMessage& message, Severity severity);

}  // namespace conddp
