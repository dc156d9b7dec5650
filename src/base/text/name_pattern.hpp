#pragma once

#include <cstddef>
#include <string>

namespace conddp {

/// How well a name of a file, in which `*` stands for any letters, fits this one: 0 not at all,
/// most the name itself, and a longer pattern better than a shorter one.
std::size_t fit(const std::string& pattern, const std::string& name);
bool fits(const std::string& pattern, const std::string& name);
/// Whether a name of a file may mean several.
bool is_pattern(const std::string& name);

}  // namespace conddp
