#pragma once

#include <Eigen/Core>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// What an evaluation adds to the cost for the constraints, a number each per constraint row of the
/// problem (ShootingProblem::constraint_offset). With values g in sets C it is
///   Σ ½ penalty · dist²(g + shift, C) + Σ multiplierᵀ g;
/// its derivative by g are the multipliers ν = penalty · (g + shift − Π_C(g + shift)) + multiplier.
/// With shift = ν/penalty it is the augmented Lagrangian, to a constant; with penalty 0 the
/// Lagrangian. Rows of one cone have one penalty.
struct Augmentation {
  explicit Augmentation(const ShootingProblem& problem)
      : penalty(Eigen::VectorXd::Zero(problem.constraint_rows())),
        shift(penalty),
        multiplier(penalty) {}

  Eigen::VectorXd penalty, shift, multiplier;
};

}  // namespace conddp
