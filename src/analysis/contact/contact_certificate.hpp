#pragma once

#include <functional>

#include "analysis/certificate/certificate.hpp"
#include "analysis/contact/contact_measures.hpp"
#include "analysis/contact/contact_replay.hpp"
#include "analysis/contact/contact_sequence.hpp"

namespace conddp {

/// Certificate of a contact-implicit motion.
struct ContactCertificate {
  ContactMeasures measures;
  std::vector<ContactStretch> sequence;
  std::vector<std::string> candidates;  ///< names of the candidates
  int first_knot = 0;                   ///< first knot of the sequence
  std::optional<ContactReplay> replay;
};

/// Computes measures, sequence and names, but no replay.
ContactCertificate certify_contacts(const ContactMotion& motion);

/// Checks that a converged contact-implicit answer must pass. Its steps are steps of the plant, and
/// each pair of force and distance is complementary. Nothing penetrates or pulls, friction obeys
/// Coulomb's law, and no force acts at a distance. Each check claims 0. docs/verification.md has
/// the formulas and tolerances. `place` names a step and its candidate, stop or joint.
std::vector<Check> contact_checks(
    const ContactMotion& motion, const ContactMeasures& measures,
    const SolverOptions::Tolerances& tolerances,
    const std::function<std::string(int knot, const std::string& what)>& place);

}  // namespace conddp
