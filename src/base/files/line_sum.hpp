#pragma once

#include <string>
#include <string_view>

namespace conddp {

/// A JSON object on a line with a check sum of it in front, `{"sum":"01234567",...}`.
std::string with_sum(std::string_view line);

/// Whether a line begins with a check sum.
bool has_sum(std::string_view line);

/// The line without its sum; empty where it has none or that does not fit.
std::string without_sum(std::string_view line);

}  // namespace conddp
