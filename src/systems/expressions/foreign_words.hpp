#pragma once

#include <string_view>

namespace conddp {

/// What to write for a name, a function or an operator in words that other languages have; empty
/// for what is not known.
std::string_view foreign_name_hint(std::string_view name);
std::string_view foreign_function_hint(std::string_view name);
std::string_view foreign_operator_hint(std::string_view word);

}  // namespace conddp
