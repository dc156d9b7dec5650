#pragma once

#include <string>
#include <vector>

#include "output/report/solution_certificate.hpp"

namespace conddp {

/// The verdict, all checks and the replay, if any, for solution.json and `verify --json`.
OrderedJson certificate_json(const SolutionCertificate& certificate);

/// All checks of a certificate: name, verdict, figures, place, message.
OrderedJson checks_json(const Certificate& certificate);

/// One line: the first failed check, which must exist, and the number of further ones.
std::string failure_line(const Certificate& certificate);

/// Examples: "certified local minimum", "stationary"; "consistency check passed" for an answer that
/// did not converge.
std::string verdict_text(Verdict verdict);

/// One line: "certified local minimum (31 checks)", another verdict with its reason, or the first
/// failed check.
std::string certificate_line(const SolutionCertificate& certificate);

/// A table of all checks: claimed, found, tolerance, place.
std::string certificate_table(const Certificate& certificate);

/// Stationarity along the certificate's own gains and by a plain adjoint, in one sentence.
std::string optimality_line(const SolutionCertificate& certificate);

/// Outcome of the replay on a finer grid, in one sentence. The replay must exist.
std::string replay_line(const SolutionCertificate& certificate);

/// Warnings about a consistent answer: a coarse grid, and in the replay, ineffective feedback and
/// violated limits.
std::vector<std::string> certificate_warnings(const SolutionCertificate& certificate);

}  // namespace conddp
