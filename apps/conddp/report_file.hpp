#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "output/report.hpp"

namespace conddp {

/// Whether the page of reports is built in. If not, prints an error that says what is missing.
bool reports_can_be_made();

/// Writes the page of a report with its data (report_data()), whole or, with an OutputError, not at
/// all. Returns its path.
std::string write_report(const OrderedJson& data, const std::filesystem::path& file);

}  // namespace conddp
