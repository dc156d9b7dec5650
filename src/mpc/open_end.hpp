#pragma once

#include <memory>
#include <vector>

#include "ocp/problem/problem.hpp"
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

/// Last node of windows that end before the time line does. Its references that are states may move
/// with time.
class OpenEnd {
 public:
  /// `path`: states of these references over time; null if they stay. Throws std::invalid_argument
  /// if its states do not fit the node.
  OpenEnd(Phase phase, std::shared_ptr<const StatePath> path);

  /// Moves the references along another path from now on; null keeps the former path.
  void follow(std::shared_ptr<const StatePath> path);
  /// Moves the references to the path's state at `time` (s), the end of windows. Allocates nothing.
  void move_to(double time);
  const Phase& phase() const { return phase_; }

 private:
  void check(const StatePath& path) const;

  Phase phase_;
  std::shared_ptr<const StatePath> path_;
  std::vector<int> references_;  ///< their offsets in the parameters
  std::vector<double> tangent_;
};

}  // namespace conddp
