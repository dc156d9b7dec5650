#pragma once

#include "analysis/certificate/replay.hpp"
#include "analysis/contact/contact_certificate.hpp"
#include "analysis/findings/findings.hpp"
#include "base/json/ordered_json.hpp"
#include "output/solution/solution.hpp"

namespace conddp {

/// Result of checking a solution.
struct SolutionCertificate {
  bool converged = false;                      ///< claim of the answer
  Certificate checks;                          ///< decisive checks
  std::optional<Replay> replay;                ///< additional information, if requested
  std::vector<Finding> findings;               ///< in the trajectory of the answer
  std::optional<ContactCertificate> contacts;  ///< of contact-implicit problems
  std::string grid_warning;  ///< for a refined grid coarser than the file requires, or empty
  std::vector<std::string> tangent_names;
  double time_s = 0;  ///< duration of the check
};

/// Checks an answer in memory: the checks of certify() and contact_checks(), constraints, contact
/// forces and the log. Statements of its document hold, because they are written from the problem.
SolutionCertificate certify_answer(const Solution& solution);

/// Adds the checks of the nulls in the document of this answer.
void note_nulls(const OrderedJson& document, Certificate& certificate);

/// Checks the document of a solution against its problem: the checks of certify_answer(), and the
/// statements of the document. On request, it also replays the solution on a finer grid. If shapes
/// do not match, nothing else is compared. Throws MalformedSolution if the document lacks keys.
SolutionCertificate certify_solution(const OrderedJson& document, const BuiltProblem& built,
                                     bool with_replay);

}  // namespace conddp
