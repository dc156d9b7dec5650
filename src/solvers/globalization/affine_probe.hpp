#pragma once

#include <Eigen/Core>

#include "ocp/evaluation/evaluator.hpp"

namespace conddp {

/// Tests by one evaluation whether dynamics and constraint rows are affine. They are if the
/// linearization at an iterate predicts the gaps and constraint values of a trajectory that is
/// moved by up to 1 in every direction.
class AffineProbe {
 public:
  explicit AffineProbe(const ShootingProblem& problem);

  /// True if dynamics and rows are affine. `linearization` belongs to the trajectory.
  bool holds(Evaluator& evaluator, const Trajectory& trajectory,
             const Linearization& linearization);

 private:
  /// Largest difference between predicted and found values, and the largest value.
  struct Comparison {
    double off = 0, largest = 1;

    void add(double foretold, double found);
    bool agrees() const;
  };
  Eigen::VectorBlock<Eigen::VectorXd> move_of(int knot, int nu);
  void move_all(const Trajectory& trajectory, const Linearization& linearization);
  void compare_gap(int knot, const Trajectory& trajectory, const Linearization& linearization,
                   Comparison& comparison);

  const ShootingProblem& problem_;
  Trajectory moved_;
  Evaluation evaluation_;
  Eigen::VectorXd z_, next_;    ///< scratch: the move of a knot, and its effect on the next
  Eigen::VectorXd constraint_;  ///< predicted
};

}  // namespace conddp
