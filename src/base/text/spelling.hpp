#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace conddp {

/// Number of edits (insert, delete, replace, swap of adjacent letters) from one word to the other,
/// ignoring case.
int edit_distance(std::string_view a, std::string_view b);

/// "1 item", "2 items".
std::string counted(std::size_t count, std::string_view what);

/// The first names of a list: "a, b, c and 3 more".
std::string listed(const std::vector<std::string>& names, std::size_t shown = 6);

/// Likely corrections of a misspelled name: at most three, the nearest first.
std::vector<std::string> similar_names(std::string_view name,
                                       const std::vector<std::string>& candidates);

/// A hint for an unknown name: "did you mean 'a' or 'b'?", or else the list of available `what`,
/// limited to eight.
std::string name_hint(std::string_view name, const std::vector<std::string>& candidates,
                      std::string_view what);

/// How well a pattern, where `*` stands for any characters, matches a file name. 0 means no match,
/// and longer patterns score higher. The name itself scores highest.
std::size_t fit(const std::string& pattern, const std::string& name);
bool fits(const std::string& pattern, const std::string& name);
/// True if a file name is a pattern.
bool is_pattern(const std::string& name);

}  // namespace conddp
