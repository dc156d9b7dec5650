#include "problem_file/build/linear_controls.hpp"

#include <fmt/format.h>

#include "problem_file/spec/named_phases.hpp"

namespace conddp {
namespace {

/// Reports phases with jumps of the controls or of the forces that they cause.
void check_continuity(const ProblemSpec& spec, Diagnostics& out) {
  for (const PhaseSpec& phase : spec.phases)
    if (phase.jump || (phase.contacts.any() && !phase.choice))
      return out.error(phase.name.place,
                       phase.jump ? "a jump interrupts the controls: linear ones cannot pass it"
                                  : "linear controls do not support contacts",
                       "write 'controls: constant'");
}

/// Linear controls are continuous across phases, so their bounds must apply in all phases.
void check_bounds(const ProblemSpec& spec, Diagnostics& out) {
  for (const ControlBoundsSpec& bounds : spec.control_bounds) {
    const std::vector<bool> named = phases_named(bounds.phases, spec, out);
    for (std::size_t p = 0; p < named.size(); ++p)
      if (!named[p] && !spec.phases[p].takes_no_time())
        return out.error(bounds.name.place, "bounds on linear controls hold in all phases",
                         "leave 'phases' out");
  }
}

/// The first control must be either given or chosen in the first phase.
void check_start(const ProblemSpec& spec, Diagnostics& out) {
  const bool given = spec.initial_state.previous_control.has_value();
  const bool chosen = spec.phases.front().choice.has_value();
  if (given && chosen)
    out.error(spec.initial_state.previous_control->place,
              "the first linear control is free in the first phase, and given here",
              "leave one of them out");
  if (!given && !chosen)
    out.error(spec.controls.place,
              "the first linear control needs a first phase 'choose', and there is none",
              "write '- {choose: none}' as the first of the phases, or give it: 'initial_state: "
              "{previous_control: 0}'");
}

void check_terms(const ProblemSpec& spec, Diagnostics& out) {
  if (const CostSpec* rate = spec.first_use(&ResidualNeeds::previous_control))
    out.error(rate->residual.place,
              fmt::format("'{}' needs controls that are constant between knots",
                          spec.use_of_previous_control()),
              "write 'controls: constant', or make the control a state and its rate the control");
  if (spec.terminal_lqr)
    out.error(spec.terminal_lqr->place, "'lqr' does not support linear controls",
              "write 'controls: constant', or give the terminal cost by 'matrix'");
}

}  // namespace

bool check_linear_controls(const ProblemSpec& spec, const System& system, Diagnostics& out) {
  if (!spec.has_linear_controls()) return true;
  const int errors = out.error_count();
  const auto fail = [&](const char* message) {
    out.error(spec.controls.place, message, "write 'controls: constant'");
  };
  if (spec.stepping) fail("contact-implicit steps do not support linear controls");
  if (system.kind() == SystemKind::discrete)
    fail("a system that gives the next state itself has no controls between its knots");
  if (spec.terminal_contacts && spec.terminal_contacts->any())
    fail("linear controls do not support contacts, and the last node holds some");
  check_continuity(spec, out);
  check_bounds(spec, out);
  check_start(spec, out);
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
