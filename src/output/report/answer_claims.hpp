#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "analysis/certificate/solution_claims.hpp"
#include "ocp/problem/by_name.hpp"
#include "output/solution/contact_forces.hpp"
#include "solvers/common/iteration_record.hpp"

namespace conddp {

struct Solution;

/// All that the certificate of an answer compares: plain numbers, whether they come from memory or
/// from a document.
struct AnswerClaims {
  SolutionClaims solution;
  int iterations = 0;
  double duration = 0;                ///< s
  Eigen::VectorXd constraint_values;  ///< of all constraint rows of the problem
  std::vector<ConstraintViolation> violations, soft_violations;
  std::vector<std::pair<std::string, double>> dropped;  ///< violations of omitted constraints
  ContactForces forces;
  /// Error of a refined grid, and the error that was asked for.
  std::optional<std::pair<double, double>> grid_error;
  /// Rows of the log. Of the last row, cost and residuals count, of the others the iteration.
  std::vector<IterationRecord> log;
};

/// The claims of an answer in memory.
AnswerClaims answer_claims(const Solution& solution);

}  // namespace conddp
