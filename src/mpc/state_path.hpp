#pragma once

#include <vector>

#include "systems/state_manifold.hpp"

namespace conddp {

/// States over time, interpolated along the shortest path on the manifold; constant before the
/// first state and after the last.
struct StatePath {
  std::vector<double> times;  ///< s, increasing; at least one
  std::vector<std::vector<double>> states;

  /// Writes the state at a time (s). `tangent` is scratch of ndx numbers.
  void state_at(const StateManifold& manifold, double time, double* tangent, double* x) const;
};

}  // namespace conddp
