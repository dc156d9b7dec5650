#pragma once

#include "analysis/findings/findings.hpp"
#include "base/json/ordered_json.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// What stands out in a motion of a problem (find_in_motion), by the names of its file.
std::vector<Finding> findings_of(const ProblemSpec& spec, const BuiltProblem& built,
                                 const Trajectory& trajectory,
                                 const std::vector<Eigen::MatrixXd>& gains,
                                 const NodeValues& values);

/// The list `findings` of solution.json.
OrderedJson findings_json(const std::vector<Finding>& findings);

/// For people: one line a finding, and of each kind the worst three, then how many more there are.
std::vector<std::string> finding_lines(const std::vector<Finding>& findings);

}  // namespace conddp
