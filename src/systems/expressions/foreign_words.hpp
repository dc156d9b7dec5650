#pragma once

#include <string_view>

namespace conddp {

/// Suggests a replacement for a name, a function or a word operator of other languages; empty if
/// unknown.
std::string_view foreign_name_hint(std::string_view name);
std::string_view foreign_function_hint(std::string_view name);
std::string_view foreign_operator_hint(std::string_view word);

}  // namespace conddp
