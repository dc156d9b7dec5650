#include "analysis/contact/rigid_step.hpp"

#include <gtest/gtest.h>

#include "support/stepping_robot.hpp"

namespace conddp {
namespace {

/// A floating robot that rotates by less or more than a radian, covering both series and sines.
class RigidStep : public ::testing::TestWithParam<double> {
 protected:
  RigidStep()
      : system_(
            stepping_robot(true, SteppingScheme::backward_euler, FrictionModel::polyhedron, true)),
        robot_(system_->multibody().robot()),
        q_(system_->manifold().neutral()),
        d_(system_->ndx(), 0.0) {
    RandomNumbers random(5);
    std::vector<double> off(system_->ndx());
    for (double& x : off) x = random.uniform(-1, 1);
    system_->manifold().integrate(q_.data(), off.data(), q_.data());
    for (int i = 0; i < robot_.nv; ++i) d_[i] = random.uniform(-1, 1) * GetParam();
  }
  std::vector<double> moved(const std::vector<double>& d) const {
    std::vector<double> out(robot_.nq);
    move_configuration(robot_, q_.data(), d.data(), out.data());
    return out;
  }

  std::shared_ptr<const SteppingSystem> system_;
  const RobotModel& robot_;
  std::vector<double> q_, d_;
};

TEST_P(RigidStep, MatchesTheStateManifold) {
  std::vector<double> state(system_->nx());
  system_->manifold().integrate(q_.data(), d_.data(), state.data());
  const std::vector<double> q = moved(d_);
  for (int i = 0; i < robot_.nq; ++i) EXPECT_NEAR(q[i], state[i], 1e-14) << i;
}

TEST_P(RigidStep, IsFoundAgainFromItsEnds) {
  std::vector<double> difference(robot_.nv);
  configuration_difference(robot_, q_.data(), moved(d_).data(), difference.data());
  for (int i = 0; i < robot_.nv; ++i) EXPECT_NEAR(difference[i], d_[i], 1e-13) << i;
}

TEST_P(RigidStep, MatchesFiniteDifferences) {
  constexpr double kStep = 1e-6;
  for (int j = 0; j < robot_.nv; ++j) {
    std::vector<Dual<double>> d(d_.begin(), d_.end()), dual(robot_.nq);
    d[j].d = 1;
    move_configuration(robot_, q_.data(), d.data(), dual.data());
    std::vector<double> up = d_, down = d_;
    up[j] += kStep;
    down[j] -= kStep;
    const std::vector<double> above = moved(up), below = moved(down);
    for (int i = 0; i < robot_.nq; ++i)
      EXPECT_NEAR(dual[i].d, (above[i] - below[i]) / (2 * kStep), 1e-8) << i << " by " << j;
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, RigidStep, ::testing::Values(1e-3, 0.5, 1.5));

}  // namespace
}  // namespace conddp
