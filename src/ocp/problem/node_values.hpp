#pragma once

#include <map>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "ocp/problem/problem.hpp"
#include "spatial/se3.hpp"

namespace conddp {

/// Evaluates nodes of a problem one by one, with one workspace per model.
class NodeEvaluation {
 public:
  explicit NodeEvaluation(const ShootingProblem& problem) : problem_(problem) {}

  /// Evaluates a node at a state and a control (null at the terminal node). The result remains
  /// valid until another node of the same model is evaluated.
  const KnotWorkspace<double>& at(int node, const double* x, const double* u);
  /// Evaluates a node with derivatives, except Hessians.
  const KnotWorkspace<double>& derivatives_at(int node, const double* x, const double* u);
  /// Evaluates a node at its state and control in a trajectory.
  const KnotWorkspace<double>& at(int node, const Trajectory& trajectory);

 private:
  KnotInput<double> input(int node, const double* x, const double* u) const;
  KnotWorkspace<double>& workspace(const KnotModel& model);

  const ShootingProblem& problem_;
  std::map<const KnotModel*, std::unique_ptr<KnotWorkspace<double>>> work_;
};

/// A contact of a knot's system, at the state and control of the knot.
struct HeldContact {
  SE3<double> world;    ///< placement of its frame in the world
  SE3<double> in_base;  ///< and in what it touches
  Force<double> force;  ///< on the robot in world axes, at the frame's origin: N, Nm
};

/// Values at all nodes of a trajectory, each evaluated once in scalar arithmetic.
class NodeValues {
 public:
  NodeValues(const ShootingProblem& problem, const Trajectory& trajectory);

  /// True if the values belong to this trajectory of the same problem.
  bool are_at(const Trajectory& trajectory) const { return trajectory == trajectory_; }
  /// The scaled cost of each term of a node's model.
  std::span<const double> term_costs(int node) const {
    return std::span(term_costs_)
        .subspan(first_cost_[node], first_cost_[node + 1] - first_cost_[node]);
  }
  /// The scaled cost of each constraint term of a node's model: 0 for hard constraints.
  std::span<const double> soft_costs(int node) const {
    return std::span(soft_costs_)
        .subspan(first_soft_[node], first_soft_[node + 1] - first_soft_[node]);
  }
  /// g and the residuals of barriers, all constraint rows of the problem.
  const Eigen::VectorXd& constraint() const { return constraint_; }
  /// f(x_k, u_k) in column k: nx x N.
  const Eigen::MatrixXd& next() const { return next_; }
  /// The contacts of a knot's system, in its order; empty for systems that are not robots.
  std::span<const HeldContact> contacts(int knot) const { return contacts_[knot]; }
  /// True if all numbers are finite; those of contacts are not checked.
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
