#pragma once

#include "base/text/diagnostic.hpp"

namespace conddp {

/// Settings of automatic mesh refinement.
struct MeshSpec {
  Place place;
  double error = 1e-6;  ///< largest distance of a finer replay from the states, in their units
  int factor = 1;       ///< initial subdivision of each step of the phases
  bool is_cut = false;  ///< true if the phases already have that subdivision
};

}  // namespace conddp
