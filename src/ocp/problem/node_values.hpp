#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "ocp/problem/problem.hpp"
#include "spatial/motion.hpp"
#include "spatial/se3.hpp"

namespace conddp {

/// A contact that a knot's system holds, at the state and control of the knot.
struct HeldContact {
  SE3<double> world;    ///< of its frame in the world
  Force<double> force;  ///< on the robot in world axes, at the frame's origin: N, Nm
};

/// What the nodes of a trajectory write, each evaluated once in scalar arithmetic.
class NodeValues {
 public:
  NodeValues(const ShootingProblem& problem, const Trajectory& trajectory);

  /// Whether the values are those at a trajectory of the same problem.
  bool are_at(const Trajectory& trajectory) const { return trajectory == trajectory_; }
  /// The scaled cost of each term of a node's model.
  std::span<const double> term_costs(int node) const {
    return std::span(term_costs_)
        .subspan(first_cost_[node], first_cost_[node + 1] - first_cost_[node]);
  }
  /// The scaled cost of each constraint term of a node's model: 0 of hard ones.
  std::span<const double> soft_costs(int node) const {
    return std::span(soft_costs_)
        .subspan(first_soft_[node], first_soft_[node + 1] - first_soft_[node]);
  }
  /// g and residuals of barriers, all constraint rows of the problem.
  const Eigen::VectorXd& constraint() const { return constraint_; }
  /// f(x_k, u_k) in column k: nx x N.
  const Eigen::MatrixXd& next() const { return next_; }
  /// The contacts that the system of a knot holds, in its order; none of what is no robot.
  std::span<const HeldContact> contacts(int knot) const { return contacts_[knot]; }
  /// Whether no number but those of contacts is infinite or not a number.
  bool all_finite() const;

 private:
  Trajectory trajectory_;
  std::vector<double> term_costs_;
  std::vector<std::size_t> first_cost_;  ///< of each node, and the end
  std::vector<double> soft_costs_;
  std::vector<std::size_t> first_soft_;  ///< of each node, and the end
  Eigen::VectorXd constraint_;
  Eigen::MatrixXd next_;
  std::vector<std::vector<HeldContact>> contacts_;
};

}  // namespace conddp
