#pragma once

#include "composed_body.hpp"
#include "ocp/step/integrator.hpp"
#include "robot/contact.hpp"

namespace conddp {

/// Phases of a composed problem and their contacts.
struct ComposedGrid {
  struct Contact {
    std::string name;
    ContactKind kind = ContactKind::point;
    bool local = false;  ///< its normal rotates with the frame
  };
  struct Phase {
    std::string name;
    int first = 0, knots = 1;
    bool takes_time = true;
    Entries held;  ///< contacts
  };

  std::string text;  ///< keys `contacts` and `phases` or `gait`
  std::vector<Contact> contacts;
  std::vector<Phase> phases;  ///< empty if a gait generates them
  double duration = 0;
  bool choice = false, free_duration = false, impulse = false;

  int knots() const { return phases.empty() ? 0 : phases.back().first + phases.back().knots; }
  /// True if a phase with duration holds a contact that satisfies the predicate.
  template <class Predicate>
  bool holds(Predicate passes) const {
    for (const Phase& phase : phases)
      for (const Contact& contact : contacts)
        if (phase.takes_time && passes(contact) &&
            std::find(phase.held.begin(), phase.held.end(), contact.name) != phase.held.end())
          return true;
    return false;
  }
};

/// `smooth`: no contacts, for integrators that require it; `bounded`: the solver accepts bounds on
/// controls and hence on free durations.
ComposedGrid compose_grid(const ComposedBody& body, bool smooth, bool bounded,
                          RandomNumbers& random);

}  // namespace conddp
