#pragma once

#include <cstddef>
#include <string>

namespace conddp {

/// How well a pattern, where `*` stands for any characters, matches a file name. 0 means no match,
/// and longer patterns score higher. The name itself scores highest.
std::size_t fit(const std::string& pattern, const std::string& name);
bool fits(const std::string& pattern, const std::string& name);
/// True if a file name is a pattern.
bool is_pattern(const std::string& name);

}  // namespace conddp
