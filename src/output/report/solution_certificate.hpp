#pragma once

#include "analysis/certificate/replay.hpp"
#include "analysis/contact/contact_certificate.hpp"
#include "analysis/findings/findings.hpp"
#include "base/json/ordered_json.hpp"
#include "output/solution/answer.hpp"
#include "problem_file/build/build.hpp"

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

/// Checks the document of a solution against its problem: configuration, shapes and names, options,
/// dropped constraints, contact forces and the log, and the checks of certify() and
/// contact_checks(). On request, it also replays the solution on a finer grid. If shapes do not
/// match, nothing else is compared. Throws MalformedSolution if the document lacks keys.
/// `written`: the answer from which this process has just written the document, with the same spec
/// and built problem. The configuration then matches. If the document contains the answer's
/// trajectory, nodes and findings are not evaluated again.
SolutionCertificate certify_solution(const OrderedJson& document, const ProblemSpec& spec,
                                     const BuiltProblem& built, bool with_replay,
                                     const Answer* written = nullptr);

}  // namespace conddp
