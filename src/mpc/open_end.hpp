#pragma once

#include <memory>
#include <vector>

#include "mpc/state_path.hpp"
#include "ocp/problem/problem.hpp"

namespace conddp {

/// The last node of windows that end before the time line does. What it has of references that are
/// states may move with time.
class OpenEnd {
 public:
  /// `path`: of these references; null: they stay. Throws std::invalid_argument where its states
  /// are not those of the node.
  OpenEnd(Phase phase, std::shared_ptr<const StatePath> path);

  /// From now on the references move on another path; null: on the one before.
  void follow(std::shared_ptr<const StatePath> path);
  /// Moves them to where windows end at a time, s. Allocates nothing.
  void move_to(double time);
  const Phase& phase() const { return phase_; }

 private:
  void check(const StatePath& path) const;

  Phase phase_;
  std::shared_ptr<const StatePath> path_;
  std::vector<int> references_;  ///< where they start in the parameters
  std::vector<double> tangent_;
};

}  // namespace conddp
