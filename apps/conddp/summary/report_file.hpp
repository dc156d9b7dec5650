#pragma once

#include <string>

#include "output/report/report.hpp"

namespace conddp {

/// True if the report page is embedded. If not, prints an error with the missing parts.
bool reports_can_be_made();

/// The page of a report with its data (report_data()).
std::string report_text(const OrderedJson& data);

}  // namespace conddp
