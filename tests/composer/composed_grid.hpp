#pragma once

#include "composed_body.hpp"
#include "ocp/knot/integrator.hpp"
#include "robot/contact.hpp"

namespace conddp {

/// Phases of a composed problem, and the contacts that they hold.
struct ComposedGrid {
  struct Contact {
    std::string name;
    ContactKind kind = ContactKind::point;
    bool local = false;  ///< its normal turns with the frame
  };
  struct Phase {
    std::string name;
    int first = 0, knots = 1;
    bool takes_time = true;
    Entries held;  ///< contacts
  };

  std::string text;  ///< the keys `contacts` and `phases` or `gait`
  std::vector<Contact> contacts;
  std::vector<Phase> phases;  ///< empty where a gait makes them
  double duration = 0;
  bool choice = false, free_duration = false, impulse = false;

  int knots() const { return phases.empty() ? 0 : phases.back().first + phases.back().knots; }
  /// Whether a phase that takes time holds a contact that passes.
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

/// `smooth`: without contacts, for integrators that need that; `bounded`: the solver takes bounds
/// on the control, hence on durations that are chosen.
ComposedGrid compose_grid(const ComposedBody& body, bool smooth, bool bounded,
                          RandomNumbers& random);

}  // namespace conddp
