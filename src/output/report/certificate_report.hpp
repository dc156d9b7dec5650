#pragma once

#include <string>
#include <vector>

#include "output/report/solution_certificate.hpp"

namespace conddp {

/// The verdict, all checks and the replay if there was one, for solution.json and `verify --json`.
OrderedJson certificate_json(const SolutionCertificate& certificate);

/// All checks, as that has them: name, verdict, figures, place, message.
OrderedJson checks_json(const Certificate& certificate);

/// One line: the first check that does not hold, which there must be, and how many more.
std::string failure_line(const Certificate& certificate);

/// "certified local minimum", "stationary", ...; of an answer that did not converge "consistency
/// check passed".
std::string verdict_text(Verdict verdict);

/// One line: "certified local minimum (31 checks)", another verdict with its reason, or the first
/// check that does not hold.
std::string certificate_line(const SolutionCertificate& certificate);

/// A table of all checks: claimed, found, tolerance, place.
std::string certificate_table(const Certificate& certificate);

/// Stationarity along the certificate's own gains and by a plain adjoint, one sentence.
std::string optimality_line(const SolutionCertificate& certificate);

/// What the plan does on a finer grid, one sentence; there must have been a replay.
std::string replay_line(const SolutionCertificate& certificate);

/// What of a true answer deserves attention: a grid that is too coarse, and of the replay feedback
/// that does not hold the motion and limits that are violated.
std::vector<std::string> certificate_warnings(const SolutionCertificate& certificate);

}  // namespace conddp
