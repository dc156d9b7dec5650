#include "analysis/contact/contact_certificate.hpp"

#include <algorithm>

namespace conddp {

ContactCertificate certify_contacts(const ContactMotion& motion) {
  ContactCertificate result{
      measure_contacts(motion), contact_sequence(motion), {}, motion.first_knot, {}};
  for (const ContactCandidate& candidate : motion.plant.contacts.candidates)
    result.candidates.push_back(candidate.name);
  return result;
}

std::vector<Check> contact_checks(
    const ContactMotion& motion, const ContactMeasures& measures,
    const SolverOptions::Tolerances& tolerances,
    const std::function<std::string(int knot, const std::string& what)>& place) {
  std::vector<Check> checks;
  const auto add = [&](const char* name, const WorstFigure& worst, double tolerance) {
    Check check{name};
    check.claimed = 0;
    check.found = worst.value;
    check.tolerance = tolerance;
    check.holds = worst.value <= tolerance;
    if (!check.holds && worst.knot >= 0) check.place = place(worst.knot, worst.what);
    checks.push_back(std::move(check));
  };
  // Errors that the tolerances of the solve allow.
  const double weight = impulse_scale(motion.plant, 1);
  const double shortest =
      motion.h.empty() ? 1 : *std::min_element(motion.h.begin(), motion.h.end());
  add("contact stepping", measures.stepping,
      std::max(1e-8, (tolerances.constraint +
                      tolerances.gap * motion.plant.robot->total_mass() / shortest) /
                         weight));
  const double pair = std::max(1e-6, tolerances.constraint);
  add("contact complementarity", measures.complementarity, pair);
  add("contact penetration", measures.penetration, pair);
  add("contact pull", measures.signs, pair);
  add("contact friction", measures.friction, pair);
  add("contact friction cone", measures.cone, pair);
  add("contact dissipation", measures.dissipation, 2 * pair);
  add("force at a distance", measures.distant, 1e-4);
  return checks;
}

}  // namespace conddp
