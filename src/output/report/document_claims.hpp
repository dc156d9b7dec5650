#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "analysis/certificate/certificate.hpp"
#include "analysis/certificate/check.hpp"
#include "analysis/certificate/solution_claims.hpp"
#include "analysis/findings/findings.hpp"
#include "base/json/ordered_json.hpp"
#include "ocp/problem/by_name.hpp"
#include "output/solution/contact_forces.hpp"
#include "output/solution/free_numbers.hpp"
#include "problem_file/assemble/build.hpp"
#include "solvers/common/iteration_record.hpp"

namespace conddp {

struct Solution;

/// All that the certificate of an answer compares: plain numbers, whether they come from memory or
/// from a document.
struct AnswerClaims {
  SolutionClaims solution;
  int iterations = 0;
  double duration = 0;  ///< s
  std::vector<FreeNumber> free_numbers;
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

/// Names of the checks that read_claims() makes for a document that matches its problem.
std::vector<std::string> statement_names(const ShootingProblem& problem);

/// Reads the claims of a solution document. Adds checks of its configuration, names, options and
/// shapes. Returns nothing if shapes do not match the problem. Throws MalformedSolution if the
/// document lacks keys.
std::optional<AnswerClaims> read_claims(const OrderedJson& document, const BuiltProblem& built,
                                        std::vector<Check>& checks);

/// Compares the list of findings in a document with those about the motion.
Check findings_check(const OrderedJson& list, const std::vector<Finding>& found);

/// Counts the nulls of a document, and compares the certificate that it contains with this one.
void check_nulls_and_certificate(const OrderedJson& document, Certificate& certificate);

/// Checks that the problem written in an answer, with all defaults, equals the built problem except
/// for the initial guess. The message names the first difference.
Check configuration_check(const OrderedJson& claimed, const BuiltProblem& built);

}  // namespace conddp
