// Residual values, compared with references, kinematics, and time differences; derivatives alone do
// not reveal a missing reference or a wrong direction.
#include <gtest/gtest.h>

#include "ocp/knot/knot_model.hpp"
#include "ocp/residuals/residuals.hpp"
#include "support/knot_case.hpp"
#include "support/named_residuals.hpp"

namespace conddp {
namespace {

std::shared_ptr<const MultibodySystem> robot_of(bool floating) {
  const auto robot = std::make_shared<RobotModel>(
      random_robot(51, {.joints = 5, .floating = floating, .wrenches = 0}));
  return std::make_shared<MultibodySystem>(robot, Actuation::full(*robot));
}

/// Rows of a residual at a state and control.
Eigen::VectorXd rows_of(const std::shared_ptr<const MultibodySystem>& system,
                        const std::shared_ptr<const Residual>& residual,
                        const std::vector<double>& x, const std::vector<double>& u,
                        std::vector<double> reference = {}) {
  KnotModel model(system, Integrator::semi_implicit_euler);
  model.add_constraint(make_constraint("rows", residual, ConstraintKind::bounds));
  reference.resize(residual->parameter_count(), 0.0);
  std::vector<double> parameters = std::move(reference);
  parameters.insert(parameters.end(), 2 * residual->size(), 0.0);
  parameters.push_back(1);
  KnotWorkspace<double> work(model);
  model.evaluate(KnotInput<double>{x.data(), u.data(), parameters.data(), 0.1, 1.0}, work);
  return Eigen::Map<const Eigen::VectorXd>(work.constraint.data(), residual->size());
}

TEST(ResidualValues, AreDifferencesFromTheirReference) {
  RandomNumbers random(31);
  int checked = 0;
  for (const bool floating : {false, true}) {
    const auto system = robot_of(floating);
    const KnotModel shape(system, Integrator::semi_implicit_euler);
    const std::vector<double> x = random_manifold_state(system->manifold(), random, 1);
    const std::vector<double> u = random.numbers(system->nu(), 1);
    for (const auto& [name, residual] : named_residuals(system, shape)) {
      const int n = residual->parameter_count();
      if (n != residual->size()) continue;
      if (name == "state" || name.starts_with("rotation") || name.starts_with("placement") ||
          name.starts_with("weighted"))
        continue;  // not differences
      const std::vector<double> reference = random.numbers(n, 2);
      const Eigen::VectorXd at_zero = rows_of(system, residual, x, u);
      const Eigen::VectorXd there = rows_of(system, residual, x, u, reference);
      for (int i = 0; i < n; ++i)
        EXPECT_NEAR(there[i], at_zero[i] - reference[i], 1e-12) << name << " row " << i;
      ++checked;
    }
  }
  EXPECT_GT(checked, 20);
}

/// State after a short time at constant velocity.
std::vector<double> moved(const MultibodySystem& system, const std::vector<double>& x,
                          double time) {
  std::vector<double> step(system.ndx(), 0.0), next(x.size());
  const int nv = system.nv(), nq = static_cast<int>(x.size()) - nv;
  for (int i = 0; i < nv; ++i) step[i] = time * x[nq + i];
  system.manifold().integrate(x.data(), step.data(), next.data());
  return next;
}

TEST(ResidualValues, FrameVelocitiesAreRatesOfPositions) {
  RandomNumbers random(32);
  constexpr double kTime = 1e-5;
  for (const bool floating : {false, true}) {
    const auto system = robot_of(floating);
    const std::vector<double> x = random_manifold_state(system->manifold(), random, 1);
    const std::vector<double> u(system->nu(), 0.0);
    for (int f = 0; f < static_cast<int>(system->robot().frames.size()); ++f) {
      const auto position = frame_position_residual(system, f);
      const Eigen::VectorXd rate = (rows_of(system, position, moved(*system, x, kTime), u) -
                                    rows_of(system, position, moved(*system, x, -kTime), u)) /
                                   (2 * kTime);
      const Eigen::VectorXd twist =
          rows_of(system, frame_velocity_residual(system, f, FrameAxes::world_aligned), x, u);
      for (int i = 0; i < 3; ++i) EXPECT_NEAR(twist[i], rate[i], 1e-6) << "frame " << f;
      // A contact constrains the components along its directions.
      const Vector3<double> normal{0.36, -0.48, 0.8}, tangent{0.8, 0.6, 0};
      const auto held = [&](ContactKind kind) {
        return rows_of(
            system,
            contact_velocity_residual(
                system, {.frame = f, .kind = kind, .normal = normal, .tangent = tangent}),
            x, u);
      };
      const double along_normal = 0.36 * rate[0] - 0.48 * rate[1] + 0.8 * rate[2];
      const double along_tangent = 0.8 * rate[0] + 0.6 * rate[1];
      const Eigen::VectorXd one = held(ContactKind::normal), two = held(ContactKind::planar);
      ASSERT_EQ(one.size(), 1);
      EXPECT_NEAR(one[0], along_normal, 1e-6) << "frame " << f;
      ASSERT_EQ(two.size(), 2);
      EXPECT_NEAR(std::abs(two[0] - along_normal) + std::abs(two[1] - along_tangent), 0, 2e-6)
          << "frame " << f << ": " << two.transpose();
      // For a point and a surface, in frame axes with equal norm.
      const Eigen::VectorXd three = held(ContactKind::point), six = held(ContactKind::surface);
      EXPECT_NEAR(three.norm(), rate.norm(), 1e-6);
      EXPECT_TRUE(six.head(3).isApprox(three, 1e-12));
      EXPECT_NEAR(six.tail(3).norm(), twist.tail(3).norm(), 1e-9);
    }
  }
}

TEST(ResidualValues, MomentumIsMassTimesCenterVelocity) {
  RandomNumbers random(33);
  constexpr double kTime = 1e-5;
  for (const bool floating : {false, true}) {
    const auto system = robot_of(floating);
    const std::vector<double> x = random_manifold_state(system->manifold(), random, 1);
    const std::vector<double> u(system->nu(), 0.0);
    double mass = 0;
    for (const Joint& joint : system->robot().joints) mass += joint.inertia.mass;
    const auto com = com_position_residual(system);
    const Eigen::VectorXd rate = (rows_of(system, com, moved(*system, x, kTime), u) -
                                  rows_of(system, com, moved(*system, x, -kTime), u)) /
                                 (2 * kTime);
    const Eigen::VectorXd momentum = rows_of(system, centroidal_momentum_residual(system), x, u);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(momentum[i], mass * rate[i], 1e-5);
  }
}

}  // namespace
}  // namespace conddp
