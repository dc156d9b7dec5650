#include "problem_file/assemble/linear_controls.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "problem_file/model/named_phases.hpp"

namespace conddp {
namespace {

bool hold_the_same(const ContactNames& a, const ContactNames& b, const ProblemSpec& spec) {
  return std::ranges::all_of(spec.contacts, [&](const ContactSpec& contact) {
    return a.has(contact.name.value) == b.has(contact.name.value);
  });
}

/// Reports nodes with two values of forces or states: costs and constraints on linear controls
/// count at both ends of a knot, and could not tell which one they mean.
void check_continuity(const ProblemSpec& spec, Diagnostics& out) {
  const char* hint = "write 'controls: constant'";
  for (const PhaseSpec& phase : spec.phases) {
    if (phase.jump || phase.restitution)
      return out.error(phase.name.place,
                       fmt::format("{} interrupts the motion: linear controls cannot pass it",
                                   phase.jump ? "a jump" : "an impulse"),
                       hint);
    if (!hold_the_same(phase.contacts, spec.phases.back().contacts, spec))
      return out.error(phase.name.place,
                       "forces jump where contacts change: linear controls cannot pass that", hint);
  }
  if (!hold_the_same(spec.last_contacts(), spec.phases.back().contacts, spec))
    out.error(spec.controls.place,
              "forces jump at the last node, which holds other contacts: linear controls cannot "
              "pass that",
              hint);
}

/// Linear controls are continuous across phases, so their bounds must apply in all phases.
void check_bounds(const ProblemSpec& spec, Diagnostics& out) {
  for (const ConstraintSpec& bounds : spec.control_bounds) {
    const std::vector<bool> named = phases_named(bounds.function.phases, spec, out);
    for (std::size_t p = 0; p < named.size(); ++p)
      if (!named[p] && !spec.phases[p].takes_no_time())
        return out.error(bounds.function.name.place, "bounds on linear controls hold in all phases",
                         "leave 'phases' out");
  }
}

void check_terms(const ProblemSpec& spec, Diagnostics& out) {
  if (const CostSpec* rate = spec.first_use(&ResidualNeeds::previous_control))
    out.error(rate->residual.place,
              fmt::format("'{}' needs controls that are constant between knots",
                          spec.use_of_previous_control()),
              "write 'controls: constant', or make the control a state and its rate the control");
  if (spec.terminal_lqr)
    out.error(spec.terminal_lqr->place,
              "a regulator sets the control at the beginning of a knot, and linear controls are "
              "set at its end",
              "write 'controls: constant', or give the terminal cost by 'matrix'");
}

}  // namespace

bool check_linear_controls(const ProblemSpec& spec, const System& system, Diagnostics& out) {
  if (!spec.has_linear_controls()) return true;
  const int errors = out.error_count();
  const auto fail = [&](const char* message) {
    out.error(spec.controls.place, message, "write 'controls: constant'");
  };
  if (spec.stepping)
    fail("impulses of contact-implicit steps count once a step: controls are constant in it");
  if (system.kind() == SystemKind::discrete)
    fail("a system that gives the next state itself has no controls between its knots");
  check_continuity(spec, out);
  check_bounds(spec, out);
  check_terms(spec, out);
  return out.error_count() == errors;
}

NodeWeights trapezoidal_weights(const std::vector<double>& weights,
                                const std::vector<double>& scales, const std::vector<bool>& apart) {
  const std::vector<double> none(weights.size() + 1, 0.0);
  NodeWeights at{none, none};
  for (std::size_t k = 0; k < weights.size(); ++k) {
    at.nodes[k] += 0.5 * weights[k];
    const double next = k + 1 < scales.size() ? scales[k + 1] : 1;
    (apart[k + 1] ? at.ends : at.nodes)[k + 1] += 0.5 * weights[k] * scales[k] / next;
  }
  return at;
}

}  // namespace conddp
