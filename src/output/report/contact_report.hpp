#pragma once

#include <string>
#include <vector>

#include "analysis/contact/contact_certificate.hpp"
#include "base/json/ordered_json.hpp"

namespace conddp {

/// Figures, energy, contact sequence and, if available, the replay: `contacts` of a certificate in
/// solution.json and `verify --json`. Names are those of the tangent vector.
OrderedJson contact_certificate_json(const ContactCertificate& certificate,
                                     const std::vector<std::string>& tangent_names);

/// Example: "12 x none, 40 x heel+toe", runs of steps with their closed candidates.
std::string contact_sequence_text(const ContactCertificate& certificate);

/// One line for the summary of a solve.
std::string contact_summary(const ContactCertificate& certificate);

/// One line each: figures, friction, energy, sequence, replay.
std::vector<std::string> contact_lines(const ContactCertificate& certificate,
                                       const std::vector<std::string>& tangent_names);

}  // namespace conddp
