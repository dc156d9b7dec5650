#pragma once

#include <string>
#include <vector>

#include "base/json/ordered_json.hpp"
#include "problem_file/assemble/build.hpp"

namespace conddp {

/// A solution in a report. Without a problem (its files are missing or no longer match), the report
/// lacks robots, costs over time and limits.
struct ReportEntry {
  std::string label;     ///< name among the other solutions
  OrderedJson document;  ///< contents of solution.json
  const BuiltProblem* built = nullptr;
  std::string remark = {};  ///< reason for missing parts, shown to the reader
};

/// Throws MalformedSolution if a document lacks keys that report_data() needs, or its lists are
/// inconsistent.
void check_report_document(const OrderedJson& document);

/// Data of a report page: for each solution its head, motion scene, and curves over the nodes.
/// Numbers have eight digits. Throws MalformedSolution if a solution does not have the shape of its
/// problem.
OrderedJson report_data(const std::vector<ReportEntry>& entries);

/// Inserts the data into a page at kReportPlaceholder, escaped so that the data cannot close the
/// enclosing element or open another.
std::string report_page(const std::string& page, const OrderedJson& data);

/// Placeholder that report_page() replaces by the data.
inline constexpr const char* kReportPlaceholder = "/*CONDDP-REPORT-DATA*/";

}  // namespace conddp
