#pragma once

#include <Eigen/Core>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// Augmentation of the cost by the constraints: one number each per constraint row of the problem
/// (ShootingProblem::constraint_offset). With values g in sets C, the evaluation adds
///   Σ ½ penalty · dist²(g + shift, C) + Σ multiplierᵀ g;
/// its derivative by g is the multiplier ν = penalty · (g + shift − Π_C(g + shift)) + multiplier.
/// With shift = ν/penalty it is the augmented Lagrangian up to a constant; with penalty 0 it is the
/// Lagrangian. All rows of a cone share one penalty.
struct Augmentation {
  explicit Augmentation(const ShootingProblem& problem)
      : penalty(Eigen::VectorXd::Zero(problem.constraint_rows())),
        shift(penalty),
        multiplier(penalty) {}

  Eigen::VectorXd penalty, shift, multiplier;
};

}  // namespace conddp
