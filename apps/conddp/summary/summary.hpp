#pragma once

#include <string>
#include <vector>

#include "analysis/derivatives/derivative_check.hpp"
#include "analysis/margins/margins.hpp"
#include "base/json/ordered_json.hpp"
#include "output/report/report.hpp"
#include "output/report/solution_certificate.hpp"
#include "robot/urdf/urdf.hpp"

namespace conddp {

// Summaries of problems and answers, as JSON and as the text that is made from it.

/// The summary of a problem (problem_summary) as text.
std::string check_text(const OrderedJson& summary);

/// The comparisons with names of phases, costs, rows and columns; `holds` is true if all are within
/// the tolerance.
OrderedJson derivatives_json(const std::vector<DerivativeComparison>& comparisons,
                             const BuiltProblem& built);

/// The comparisons as a text table.
std::string derivatives_text(const OrderedJson& derivatives);

/// The output of `conddp margins --json` (schemas/margins.schema.json).
OrderedJson margins_json(const std::vector<MarginCurve>& curves, const StateNoise& noise,
                         const BuiltProblem& built, const Trajectory& trajectory);

/// The margins as text: one line per bound, the closest first.
std::string margins_text(const OrderedJson& margins);

/// The regulator, the terminal set and the conditions of `terminal: {lqr: ...}`, which the problem
/// must contain, with the names of states and controls.
OrderedJson regulator_json(const BuiltProblem& built, double constraint_tolerance);

/// The regulator as text.
std::string regulator_text(const OrderedJson& terminal);

/// The contents of a robot's file as text: tree, joints with limits, links with masses, frames, and
/// ignored parts. The result must contain a model.
std::string robot_text(const UrdfResult& robot);

/// The contents as JSON (schemas/inspect.schema.json).
OrderedJson robot_json(const UrdfResult& robot);

/// Summary of a solve as text. `certificate` may be null; `colour`: print the status in green or
/// yellow; `notes`: number of hidden notes about the input. In the form of terminal_text.
std::string summary_text(const Solution& solution, const SolutionCertificate* certificate,
                         const std::vector<std::string>& written, bool colour, int notes);

/// True if the report page is embedded. If not, prints an error with the missing parts.
bool reports_can_be_made();

/// The page of a report with its data (report_data()).
std::string report_text(const OrderedJson& data);

}  // namespace conddp
