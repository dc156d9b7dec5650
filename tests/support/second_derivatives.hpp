#pragma once

#include <gtest/gtest.h>

#include "ocp/evaluation/evaluator.hpp"
#include "ocp/knot/knot_second_derivatives.hpp"
#include "support/random_numbers.hpp"

namespace conddp {

/// True if a model has exact partwise Hessians.
inline bool known_by_parts(const KnotModel& model) {
  KnotBatch<Lane> at(model);
  KnotBatch<Dual<Lane>> moving(model);
  return KnotSecondDerivatives::make(model, at, moving) != nullptr;
}

/// Compares exact partwise Hessians of a trajectory with random costates with dual numbers through
/// all of `differentiate`.
inline void expect_hessians_of_dual_numbers(const ShootingProblem& problem,
                                            const Trajectory& trajectory,
                                            const Augmentation& augmentation,
                                            RandomNumbers& random) {
  Eigen::MatrixXd costates(problem.ndx(), problem.knots() + 1);
  for (double& l : costates.reshaped()) l = random.uniform(-1, 1);
  Evaluator evaluator(problem), reference(problem);
  reference.reserve_lagrangian_hessian(false);
  Linearization a(problem), b(problem);
  evaluator.lagrangian_hessian(trajectory, costates, a, &augmentation);
  reference.lagrangian_hessian(trajectory, costates, b, &augmentation);
  for (int k = 0; k <= problem.knots(); ++k) {
    const Eigen::MatrixXd &got = a.knots[k].hessian(), &expected = b.knots[k].hessian();
    ASSERT_TRUE(expected.allFinite()) << "knot " << k;
    ASSERT_LT((got - expected).cwiseAbs().maxCoeff(), 1e-9 * (1 + expected.cwiseAbs().maxCoeff()))
        << "knot " << k;
    EXPECT_EQ(got, got.transpose()) << "knot " << k;
  }
}

}  // namespace conddp
