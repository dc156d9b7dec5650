#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "analysis/certificate/certificate_doubt.hpp"
#include "analysis/findings/diagnosis.hpp"
#include "analysis/findings/findings.hpp"
#include "ocp/problem/by_name.hpp"
#include "output/solution/contact_forces.hpp"
#include "problem_file/mesh/mesh.hpp"
#include "solvers/common/solve_result.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {

/// Results derived from a solve under the names of its problem file, computed once for all outputs.
/// The certificate uses them, too.
struct Answer {
  Answer(const BuiltProblem& built, const SolveResult& result);

  NodeValues values;                                  ///< at the trajectory
  std::vector<std::pair<std::string, double>> costs;  ///< cost_by_name()
  std::vector<ConstraintViolation> violations;        ///< violations_by_name()
  std::vector<ConstraintViolation> soft_violations;
  std::vector<std::pair<std::string, double>> dropped;  ///< violations of omitted constraints
  Diagnosis diagnosis;
  std::vector<Finding> findings;
  ContactForces forces;
  std::shared_ptr<const LastJudged> judged;  ///< certificate from the solve, or null
};

/// The value of `format` in a solution.json.
inline constexpr std::string_view kSolutionFormat = "conddp.solution/1";

/// Data for the files of a solution.
struct Solution {
  const BuiltProblem& built;
  const SolverInfo& solver;
  const SolveResult& result;
  std::vector<std::string> overrides;  ///< command-line settings, as given
  std::vector<MeshRound> mesh = {};    ///< the grids, if the file requests refinement
  Answer answer = Answer(built, result);
};

}  // namespace conddp
