#pragma once

#include <optional>
#include <vector>

#include "analysis/certificate/certificate.hpp"
#include "analysis/findings/findings.hpp"
#include "base/json/ordered_json.hpp"
#include "output/report/answer_claims.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// Names of the checks that read_claims() makes for a document that matches its problem.
std::vector<std::string> statement_names(const ShootingProblem& problem);

/// Reads the claims of a solution document. Adds checks of its configuration, names, options and
/// shapes. Returns nothing if shapes do not match the problem. Throws MalformedSolution if the
/// document lacks keys.
std::optional<AnswerClaims> read_claims(const OrderedJson& document, const ProblemSpec& spec,
                                        const BuiltProblem& built, std::vector<Check>& checks);

/// Compares the list of findings in a document with those about the motion.
Check findings_check(const OrderedJson& list, const std::vector<Finding>& found);

/// Counts the nulls of a document, and compares the certificate that it contains with this one.
void check_nulls_and_certificate(const OrderedJson& document, Certificate& certificate);

}  // namespace conddp
