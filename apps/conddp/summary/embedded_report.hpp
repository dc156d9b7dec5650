#pragma once

#include <string_view>

namespace conddp {

/// The page of reports, built in; empty where it could not be bundled.
std::string_view report_template();

/// Why it could not, a clause; empty where it could.
std::string_view missing_for_reports();

}  // namespace conddp
