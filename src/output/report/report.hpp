#pragma once

#include <string>
#include <vector>

#include "base/json/ordered_json.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// A solution in a report. Without a problem (its files are gone, or changed so that they no longer
/// fit) there are no robots, costs over time or limits.
struct ReportEntry {
  std::string label;     ///< how it is called beside the others
  OrderedJson document;  ///< solution.json
  const ProblemSpec* spec = nullptr;
  const BuiltProblem* built = nullptr;
  std::string remark = {};  ///< why something is missing, shown to the reader
};

/// Throws MalformedSolution where a document lacks what report_data() needs, or its lists do not
/// fit together.
void check_report_document(const OrderedJson& document);

/// What the page of a report is made from: of every solution its head,
/// motion scene, and curves over the nodes. Numbers keep eight digits. Throws
/// MalformedSolution where a solution has another shape than its problem.
OrderedJson report_data(const std::vector<ReportEntry>& entries);

/// Puts the data into a page that has the line `placeholder`, so that nothing in it can end the
/// element that holds it or begin another.
std::string report_page(const std::string& page, const OrderedJson& data);

/// Where report_page() puts the data.
inline constexpr const char* kReportPlaceholder = "/*CONDDP-REPORT-DATA*/";

}  // namespace conddp
