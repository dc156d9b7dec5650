#pragma once

#include <vector>

#include "analysis/contact/contact_motion.hpp"

namespace conddp {

/// A run of steps with the same closed candidates.
struct ContactStretch {
  int first = 0, steps = 0;   ///< in steps of the motion
  std::vector<bool> closed;   ///< per candidate
  std::vector<bool> slides;   ///< per candidate: closed and sliding along its surface
  std::vector<bool> landing;  ///< per candidate: closes at the start of the stretch
  /// Forces outside the contacts of the stretch: at landings, and in contacts that are too short.
  struct Push {
    int steps = 0;
    double largest = 0;  ///< N
  };
  std::vector<Push> pushes;  ///< per candidate
  bool lands() const;
};

struct ContactSequenceOptions {
  double gap = 1e-5;    ///< m: a candidate touches below this gap
  double share = 1e-4;  ///< of the weight: a force counts above this share
  double slip = 1e-2;   ///< m/s: a contact slides if it is faster at any node
  int shortest = 2;     ///< steps: shorter contacts and flights are left out
};

/// Contact sequence that a motion found, in the form of a contact schedule. A step has a contact if
/// its force acts and the candidate touches already at the start of the step. A step that ends with
/// a landing is thus a flight step with an impact at its end. Forces in steps without such a
/// contact are reported separately.
std::vector<ContactStretch> contact_sequence(const ContactMotion& motion,
                                             const ContactSequenceOptions& options = {});

}  // namespace conddp
