#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace conddp {

/// Edits (insert, delete, replace, swap of neighbours) from one word to the other, upper and lower
/// case taken as equal.
int edit_distance(std::string_view a, std::string_view b);

/// "1 item", "2 items".
std::string counted(std::size_t count, std::string_view what);

/// The candidates that a misspelt name may have meant: at most three, the nearest first.
std::vector<std::string> similar_names(std::string_view name,
                                       const std::vector<std::string>& candidates);

/// A hint for an unknown name: "did you mean 'a' or 'b'?", else the list of `what` there is, cut
/// after eight.
std::string name_hint(std::string_view name, const std::vector<std::string>& candidates,
                      std::string_view what);

}  // namespace conddp
