#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "analysis/certificate/certificate.hpp"
#include "analysis/findings/diagnosis.hpp"
#include "analysis/findings/findings.hpp"
#include "ocp/problem/by_name.hpp"
#include "output/solution/contact_forces.hpp"
#include "problem_file/build/build.hpp"
#include "solvers/common/solve_result.hpp"

namespace conddp {

/// What follows from the result of a solve by the names of its problem's file, computed once for
/// all outputs. The certificate in the same process takes the values of the nodes and the findings
/// in them from here, if its trajectory is the same, and the model of second order from the one
/// that judged the same numbers before; everything else it computes itself.
struct Answer {
  Answer(const ProblemSpec& spec, const BuiltProblem& built, const SolveResult& result);

  NodeValues values;                                  ///< at the trajectory
  std::vector<std::pair<std::string, double>> costs;  ///< cost_by_name()
  std::vector<ConstraintViolation> violations;        ///< violations_by_name()
  std::vector<ConstraintViolation> soft_violations;
  std::vector<std::pair<std::string, double>> dropped;  ///< violations of constraints left out
  Diagnosis diagnosis;
  std::vector<Finding> findings;
  ContactForces forces;
  /// What a certificate has found of the same numbers on the way; null: nothing.
  std::shared_ptr<const SecondOrderMemory> certified;
};

}  // namespace conddp
