#pragma once

#include <map>

#include <Eigen/Core>

#include "ocp/problem/problem.hpp"
#include "ocp/problem/trajectory.hpp"

namespace conddp {

/// Ranges of motion, the scales of a certificate: of each state over the trajectory, of each
/// control over the knots of its model.
class MotionRanges {
 public:
  MotionRanges(const ShootingProblem& problem, const Trajectory& trajectory);

  /// Ranges of z = (δx, δu) at a node; zero for entries that do not move.
  Eigen::VectorXd of_node(const ShootingProblem& problem, int k) const;
  /// The same as units: entries that do not move count as 1.
  Eigen::VectorXd unit(const ShootingProblem& problem, int k) const;
  /// Largest move of each entry along a direction, in its unit: 1. Controls that are
  /// zero throughout lack a range and move as far as the largest one of their model.
  Eigen::VectorXd reach(const ShootingProblem& problem, int k) const;

 private:
  Eigen::VectorXd state_;
  std::map<const KnotModel*, Eigen::VectorXd> controls_;
};

}  // namespace conddp
