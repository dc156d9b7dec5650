#pragma once

#include <cstddef>
#include <string_view>

namespace conddp {

/// Where the quoted text that opens at `at` closes: the index of the quote, npos if it never does,
/// `at` itself if no quote stands there. yaml-cpp takes the end of the file for one.
std::size_t quote_end(std::string_view text, std::size_t at);

/// Whether the '[' or '{' at `at` has its counterpart. (yaml-cpp takes one that has not for a key.)
bool bracket_closes(std::string_view text, std::size_t at);

}  // namespace conddp
