#pragma once

#include <cstddef>
#include <string_view>

namespace conddp {

/// Index of the quote that closes a quoted text opening at `at`. Returns npos if it is never
/// closed, and `at` itself if no quote opens there. The end of the file is a closing quote to
/// yaml-cpp, but not here.
std::size_t quote_end(std::string_view text, std::size_t at);

/// True if the '[' or '{' at `at` is closed. (yaml-cpp takes an unclosed bracket for a key.)
bool bracket_closes(std::string_view text, std::size_t at);

}  // namespace conddp
