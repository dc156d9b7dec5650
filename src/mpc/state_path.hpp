#pragma once

#include <vector>

#include "systems/state_manifold.hpp"

namespace conddp {

/// States over time: between two of them on the shortest way of the manifold, before the first one
/// and after the last one those.
struct StatePath {
  std::vector<double> times;  ///< s, increasing; one at least
  std::vector<std::vector<double>> states;

  /// Writes the state at a time (s). `tangent` is scratch of ndx numbers.
  void state_at(const StateManifold& manifold, double time, double* tangent, double* x) const;
};

}  // namespace conddp
