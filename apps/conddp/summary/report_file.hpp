#pragma once

#include <string>

#include "output/report/report.hpp"

namespace conddp {

/// Whether the page of reports is built in. If not, prints an error that says what is missing.
bool reports_can_be_made();

/// The page of a report with its data (report_data()).
std::string report_text(const OrderedJson& data);

}  // namespace conddp
