#pragma once

#include "base/text/diagnostic.hpp"

namespace conddp {

/// How fine the grid becomes by itself.
struct MeshSpec {
  Place place;
  double error = 1e-6;  ///< how far a finer replay may lie from the states, in their units
  int factor = 1;       ///< into how many each step of the phases is cut to begin with
  int rounds = 8;       ///< grids at most
  int most_knots = 10000;
};

}  // namespace conddp
