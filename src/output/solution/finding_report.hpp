#pragma once

#include "analysis/findings/findings.hpp"
#include "base/json/ordered_json.hpp"
#include "problem_file/assemble/build.hpp"

namespace conddp {

/// Notable properties of a problem's motion (find_in_motion), with the names of its file.
std::vector<Finding> findings_of(const BuiltProblem& built, const Trajectory& trajectory,
                                 const std::vector<Eigen::MatrixXd>& gains,
                                 const NodeValues& values);

/// The list `findings` of solution.json.
OrderedJson findings_json(const std::vector<Finding>& findings);

/// Text for users: one line per finding, the worst three of each kind, then the number of further
/// ones.
std::vector<std::string> finding_lines(const std::vector<Finding>& findings);

}  // namespace conddp
