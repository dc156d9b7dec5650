#pragma once

#include <functional>

#include "analysis/certificate/certificate.hpp"
#include "analysis/contact/contact_measures.hpp"
#include "analysis/contact/contact_replay.hpp"
#include "analysis/contact/contact_sequence.hpp"

namespace conddp {

/// What is found out about a motion that found its own contacts.
struct ContactCertificate {
  ContactMeasures measures;
  std::vector<ContactStretch> sequence;
  std::vector<std::string> candidates;  ///< their names
  int first_knot = 0;                   ///< at which the sequence begins
  std::optional<ContactReplay> replay;
};

/// Measures, sequence and names; no replay.
ContactCertificate certify_contacts(const ContactMotion& motion);

/// The statements that a converged answer makes by being one: that its steps are those of its
/// plant, that each pair of force and distance is complementary, that nothing penetrates or pulls,
/// that friction obeys Coulomb, that no force acts at a distance. Each claims 0.
/// docs/verification.md has the formulas and tolerances. `place` names a step and what is meant
/// there.
std::vector<Check> contact_checks(
    const ContactMotion& motion, const ContactMeasures& measures,
    const SolverOptions::Tolerances& tolerances,
    const std::function<std::string(int knot, const std::string& what)>& place);

}  // namespace conddp
