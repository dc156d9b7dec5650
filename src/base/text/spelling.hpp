#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace conddp {

/// Number of edits (insert, delete, replace, swap of adjacent letters) from one word to the other,
/// ignoring case.
int edit_distance(std::string_view a, std::string_view b);

/// "1 item", "2 items".
std::string counted(std::size_t count, std::string_view what);

/// Likely corrections of a misspelled name: at most three, the nearest first.
std::vector<std::string> similar_names(std::string_view name,
                                       const std::vector<std::string>& candidates);

/// A hint for an unknown name: "did you mean 'a' or 'b'?", or else the list of available `what`,
/// limited to eight.
std::string name_hint(std::string_view name, const std::vector<std::string>& candidates,
                      std::string_view what);

}  // namespace conddp
