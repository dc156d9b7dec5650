#pragma once

#include <string_view>

namespace conddp {

/// The embedded report page; empty if it could not be bundled.
std::string_view report_template();

/// The reason why it could not be bundled, a clause; empty if it was.
std::string_view missing_for_reports();

}  // namespace conddp
