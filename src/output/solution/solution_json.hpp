#pragma once

#include <filesystem>
#include <string>
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

/// Writes solution.json, trajectory.csv, iterations.csv and, unless the page is empty, report.html
/// into a folder, which is created if needed. On an OutputError, no file is written. Returns their
/// paths. `document` is that of the solution (solution_json).
std::vector<std::filesystem::path> write_solution(const Solution& solution,
                                                  const OrderedJson& document,
                                                  const std::filesystem::path& folder,
                                                  const std::string& page);

/// The trajectory in the document of a solution, NaN for nulls. Throws MalformedSolution if its
/// shape differs from that of the problem.
Trajectory stored_trajectory(const OrderedJson& document, const ShootingProblem& problem);

}  // namespace conddp
