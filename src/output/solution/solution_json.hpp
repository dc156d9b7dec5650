#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/findings/diagnosis.hpp"
#include "base/json/ordered_json.hpp"
#include "output/solution/solution.hpp"

namespace conddp {

/// Description of a solve without its bulk data: problem, tool, status, costs, residuals, times,
/// guess.
OrderedJson solution_head(const Solution& solution);

/// Identification of conddp: version, revision, build, libraries.
OrderedJson tool_json();

/// The complete solution.json (schemas/solution.schema.json) without its certificate.
OrderedJson solution_json(const Solution& solution);

/// Columns, units and phases of a trajectory in a document.
OrderedJson motion_names(const BuiltProblem& built);

/// Adds the certificate to a document or a head.
void add_certificate(OrderedJson certificate, OrderedJson& document);

/// Number of nulls in a value.
int count_nulls(const OrderedJson& value);

/// Diagnosis of the solve: pattern, sentence, knot, quantity and remedy.
OrderedJson diagnosis_json(const Diagnosis& diagnosis);

/// The forms of an answer's files.
struct OutputFormats {
  bool json = true;  ///< solution.json
  bool csv = true;   ///< trajectory.csv, iterations.csv
  bool npz = false;  ///< trajectory.npz
};
inline constexpr std::string_view kOutputFormats = "json,csv,npz";
/// Parses some of kOutputFormats, separated by commas; nothing for another word or none.
std::optional<OutputFormats> parse_output_formats(std::string_view list);

/// Writes the files of an answer and, unless the page is empty, report.html into a folder, which is
/// created if needed. Files of this kind that are not written show an earlier answer, and are
/// removed. On an OutputError, no file is written. Returns the paths. `document` is that of the
/// solution (solution_json).
std::vector<std::filesystem::path> write_solution(const Solution& solution,
                                                  const OrderedJson& document,
                                                  const std::filesystem::path& folder,
                                                  const std::string& page,
                                                  const OutputFormats& formats = {});

/// The trajectory in the document of a solution, NaN for nulls. Throws MalformedSolution if its
/// shape differs from that of the problem.
Trajectory stored_trajectory(const OrderedJson& document, const ShootingProblem& problem);

}  // namespace conddp
