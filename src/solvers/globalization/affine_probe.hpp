#pragma once

#include <Eigen/Core>

#include "ocp/evaluation/evaluator.hpp"

namespace conddp {

/// Tells by one evaluation whether dynamics and constraint rows are affine: whether, around an
/// iterate, a linearisation foretells the gaps and constraint values of a trajectory that is 1 off
/// in every direction.
class AffineProbe {
 public:
  explicit AffineProbe(const ShootingProblem& problem);

  /// `linearization` is that of the trajectory.
  bool holds(Evaluator& evaluator, const Trajectory& trajectory,
             const Linearization& linearization);

 private:
  /// The largest difference between what was foretold and what was found, and the largest number.
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
  Eigen::VectorXd z_, next_;    ///< scratch: the move of a knot, and what it makes of the next
  Eigen::VectorXd constraint_;  ///< foretold
};

}  // namespace conddp
