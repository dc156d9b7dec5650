#pragma once

#include <string>
#include <string_view>

namespace conddp {

/// A single-line JSON object with its checksum as first member, `{"sum":"01234567",...}`.
std::string with_sum(std::string_view line);

/// True if a line begins with a checksum.
bool has_sum(std::string_view line);

/// The line without its checksum; empty if the checksum is missing or wrong.
std::string without_sum(std::string_view line);

}  // namespace conddp
