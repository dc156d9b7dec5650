#pragma once

#include "analysis/certificate/replay.hpp"
#include "analysis/contact/contact_certificate.hpp"
#include "analysis/findings/findings.hpp"
#include "base/json/ordered_json.hpp"
#include "output/solution/answer.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// What was found out about a solution.
struct SolutionCertificate {
  bool converged = false;                      ///< what the answer claims
  Certificate checks;                          ///< what decides
  std::optional<Replay> replay;                ///< what is worth knowing besides, if asked for
  std::vector<Finding> findings;               ///< in the trajectory of the answer
  std::optional<ContactCertificate> contacts;  ///< of contact-implicit problems
  std::string grid_warning;  ///< of a refined grid that is coarser than the file asks for, or empty
  std::vector<std::string> tangent_names;
  double time_s = 0;  ///< that it took
};

/// Judges the document of a solution against its problem: configuration, shapes and names,
/// options, dropped constraints, contact forces and the log, and everything that certify() and
/// contact_checks() judge; if asked for, plays it back on a finer grid, too. Where shapes do not
/// fit, nothing else is compared. Throws MalformedSolution where the document lacks keys.
/// `written`: the answer of which this process has just written the document, from the same spec
/// and built problem. The document's configuration is theirs then, and where it has the trajectory
/// of the answer, nodes are not evaluated again and findings not looked for again.
SolutionCertificate certify_solution(const OrderedJson& document, const ProblemSpec& spec,
                                     const BuiltProblem& built, bool with_replay,
                                     const Answer* written = nullptr);

}  // namespace conddp
