#pragma once

#include <vector>

#include "analysis/contact/contact_motion.hpp"

namespace conddp {

/// A run of steps in which the same candidates are closed.
struct ContactStretch {
  int first = 0, steps = 0;   ///< of the motion
  std::vector<bool> closed;   ///< per candidate
  std::vector<bool> slides;   ///< per candidate: closed, and moves along its surface
  std::vector<bool> landing;  ///< per candidate: closes where the stretch begins, not before
  /// Forces that no contact of the stretch accounts for: of landings, and of contacts too short.
  struct Push {
    int steps = 0;
    double largest = 0;  ///< N
  };
  std::vector<Push> pushes;  ///< per candidate
  bool lands() const;
};

struct ContactSequenceOptions {
  double gap = 1e-5;    ///< m: nearer than that a candidate touches
  double share = 1e-4;  ///< of the weight: a force that counts
  double slip = 1e-2;   ///< m/s: a contact that is faster at any node slides
  int shortest = 2;     ///< steps: contacts and flights that are shorter are left out
};

/// The sequence of contacts that a motion found, as a schedule of contacts needs it: a step has a
/// contact where its force acts and where the candidate touches at the step's beginning already.
/// (A step at whose end a candidate lands is one of flight with an impact at its end.) Forces in
/// steps that have no such contact are told beside it.
std::vector<ContactStretch> contact_sequence(const ContactMotion& motion,
                                             const ContactSequenceOptions& options = {});

}  // namespace conddp
