#include "ocp/residuals/residuals.hpp"

#include <gtest/gtest.h>

#include "support/knot_case.hpp"
#include "support/named_residuals.hpp"
#include "support/robots.hpp"
#include "support/sizes.hpp"

namespace conddp {
namespace {

std::vector<std::shared_ptr<const MultibodySystem>> robots() {
  std::vector<std::shared_ptr<const MultibodySystem>> systems;
  for (const bool floating : {false, true})
    for (const std::uint64_t seed : {41, 42, 43}) {
      const auto robot = std::make_shared<RobotModel>(
          random_robot(seed, {.joints = 6, .floating = floating, .wrenches = 1}));
      systems.push_back(std::make_shared<MultibodySystem>(robot, Actuation::full(*robot)));
    }
  return systems;
}

TEST(Residuals, AllGradientsMatchDualNumbersForAllActivations) {
  RandomNumbers random(17);
  const ActivationKind kinds[] = {ActivationKind::quadratic, ActivationKind::quadratic_barrier,
                                  ActivationKind::smooth_l1, ActivationKind::smooth_l2,
                                  ActivationKind::linear};
  for (const auto& system : robots())
    for (const bool memory : {false, true}) {
      const KnotModel shape(step_with(system, Integrator::semi_implicit_euler, memory));
      for (const auto& [name, residual] : named_residuals(system, shape, 2))
        for (const ActivationKind kind : kinds) {
          auto model = std::make_shared<KnotModel>(
              step_with(system, Integrator::semi_implicit_euler, memory));
          const int n = residual->size();
          std::vector<double> weights = random.numbers(n, 1);
          for (double& w : weights) w = 0.1 + std::abs(w);
          model->add_cost(
              "cost", residual,
              {kind, weights, std::vector<double>(n, -0.1), std::vector<double>(n, 0.1), 0.2});
          const KnotCase c = make_case(name, model, random);
          KnotWorkspace<double> work(*model);
          model->differentiate(
              KnotInput<double>{c.x.data(), c.u.data(), c.parameters.data(), c.dt, c.dt}, work,
              true);
          double scale = 1;
          for (double g : work.gradient) scale = std::max(scale, std::abs(g));
          for (int d = 0; d < model->nz(); d += kDirectionStride)
            EXPECT_NEAR(work.gradient[d], directional_derivative(c, d).cost, 1e-10 * scale)
                << name << " activation " << static_cast<int>(kind) << " direction " << d;
        }
    }
}

TEST(Residuals, GradientsOnFiveRobotsMatchDualNumbers) {
  RandomNumbers random(18);
  for (const TestRobot& robot : five_robots()) {
    const auto model_of = load(robot);
    const auto system = std::make_shared<MultibodySystem>(model_of, Actuation::full(*model_of));
    const KnotModel shape(system, Integrator::semi_implicit_euler);
    for (const auto& [name, residual] : named_residuals(system, shape, 3)) {
      auto model = std::make_shared<KnotModel>(system, Integrator::semi_implicit_euler);
      model->add_cost("cost", residual, {});
      const KnotCase c = make_case(name, model, random);
      KnotWorkspace<double> work(*model);
      model->differentiate(
          KnotInput<double>{c.x.data(), c.u.data(), c.parameters.data(), c.dt, c.dt}, work, true);
      double scale = 1;
      for (double g : work.gradient) scale = std::max(scale, std::abs(g));
      for (int d = 0; d < model->nz(); d += kDirectionStride)
        EXPECT_NEAR(work.gradient[d], directional_derivative(c, d).cost, 1e-9 * scale)
            << robot.name << ' ' << name << " direction " << d;
    }
  }
}

TEST(Residuals, DeclaredStructureCoversEveryDependence) {
  // A direction outside a residual's columns must not change its cost. The gradient test above
  // detects a missing column only if it is non-zero there.
  RandomNumbers random(19);
  for (const auto& system : robots()) {
    const KnotModel shape(system, Integrator::semi_implicit_euler);
    for (const auto& [name, residual] : named_residuals(system, shape, 2)) {
      auto model = std::make_shared<KnotModel>(system, Integrator::semi_implicit_euler);
      model->add_cost("cost", residual, {});
      const KnotCase c = make_case(name, model, random);
      std::vector<bool> covered(model->nz(), false);
      for (const RowBlock& block : residual->blocks())
        for (int column : block.columns) covered[column] = true;
      for (int d = 0; d < model->nz(); d += kDirectionStride)
        if (!covered[d]) {
          EXPECT_NEAR(directional_derivative(c, d).cost, 0, 1e-12) << name << ' ' << d;
        }
    }
  }
}

TEST(Residuals, PlacementErrorIsTwistFromReferenceToFrame) {
  const auto system = robots().back();
  RandomNumbers random(23);
  auto model = std::make_shared<KnotModel>(system, Integrator::semi_implicit_euler);
  const int frame = 3;
  const auto residual = frame_placement_residual(system, frame);
  const auto data = system->create_data(double{});
  const std::vector<double> x = random_manifold_state(system->manifold(), random, 1);
  system->update_kinematics(x.data(), *data);
  const auto& robot = static_cast<MultibodySystem::Data<double>&>(*data).robot;
  const SE3<double> m = frame_placement(system->robot(), robot, frame);
  const Motion<double> twist{{0.1, -0.2, 0.3}, {0.5, -1.0, 2.0}};
  const Pose<double> reference = integrate_se3(Pose<double>{m.p, quaternion(m.R)}, twist);
  const double parameters[] = {reference.p.x, reference.p.y, reference.p.z, reference.q.x,
                               reference.q.y, reference.q.z, reference.q.w};
  double r[6];
  residual->evaluate(ResidualInput<double>{x.data(), nullptr, parameters, *data}, r);
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(r[i], -twist[i], 1e-12);
}

TEST(Residuals, ExcludedCoordinatesLeaveTheOtherRows) {
  StateManifold manifold = StateManifold::flat(2);
  manifold.append(StateManifold::Part::se3);
  manifold.append(StateManifold::Part::flat, 4);
  const std::vector<int> left_out = {0, 10, 12}, rows_left_out = {0, 9, 11};
  EXPECT_EQ(without_coordinates(manifold, left_out).nx(), manifold.nx() - 3);
  const auto whole = state_residual(manifold), some = state_residual(manifold, left_out);
  ASSERT_EQ(some->size(), manifold.ndx() - 3);
  RandomNumbers random(24);
  const std::vector<double> x = random_manifold_state(manifold, random, 1),
                            reference = random_manifold_state(manifold, random, 1);
  std::vector<double> references;
  for (int i = 0; i < manifold.nx(); ++i)
    if (!std::binary_search(left_out.begin(), left_out.end(), i))
      references.push_back(reference[i]);
  ASSERT_EQ(some->parameter_count(), static_cast<int>(references.size()));
  const auto system = robots().front();
  const auto data = system->create_data(double{});
  std::vector<double> r(whole->size()), J(whole->jacobian_size());
  std::vector<double> r_some(some->size()), J_some(some->jacobian_size());
  whole->differentiate(ResidualInput<double>{x.data(), nullptr, reference.data(), *data}, r.data(),
                       J.data());
  some->differentiate(ResidualInput<double>{x.data(), nullptr, references.data(), *data},
                      r_some.data(), J_some.data());
  std::vector<double> r_of_others;
  for (int i = 0; i < manifold.ndx(); ++i)
    if (!std::binary_search(rows_left_out.begin(), rows_left_out.end(), i))
      r_of_others.push_back(r[i]);
  EXPECT_EQ(r_some, r_of_others);
  std::vector<int> columns;
  for (const RowBlock& block : some->blocks())
    columns.insert(columns.end(), block.columns.begin(), block.columns.end());
  EXPECT_EQ(columns, (std::vector<int>{1, 2, 3, 4, 5, 6, 7, 8, 10}));
  // One entry for each flat coordinate and 36 for the pose, in the same order.
  EXPECT_EQ(J_some, std::vector<double>(J.begin() + 1, J.end() - 2));
}

TEST(Activations, HessiansMatchTheirGradients) {
  using D = Dual<Lane>;
  RandomNumbers random(29);
  constexpr int n = 4;
  for (const ActivationKind kind :
       {ActivationKind::quadratic, ActivationKind::quadratic_barrier, ActivationKind::smooth_l1,
        ActivationKind::smooth_l2, ActivationKind::linear}) {
    const Activation a{
        kind, {0.5, 1, 2, 3}, std::vector<double>(n, -0.3), std::vector<double>(n, 0.4), 0.2};
    const std::vector<double> at = random.numbers(n, 1);
    double gradient[n], diagonal[n], rank_one;
    a.differentiate(at.data(), n, gradient, diagonal, rank_one);
    for (int j = 0; j < n; ++j) {
      D r[n], g[n], h[n], k;
      for (int i = 0; i < n; ++i) r[i] = D(Lane(at[i]), Lane(i == j ? 1.0 : 0.0));
      const D value = a.differentiate(r, n, g, h, k);
      EXPECT_NEAR(value.d[0], gradient[j], 1e-13);
      EXPECT_NEAR(a.value(r, n).d[0], gradient[j], 1e-13);
      for (int i = 0; i < n; ++i)
        EXPECT_NEAR(g[i].d[0], (i == j ? diagonal[i] : 0) + rank_one * gradient[i] * gradient[j],
                    1e-13)
            << "activation " << static_cast<int>(kind);
    }
  }
}

TEST(Activations, ZeroResidualInsideBoundsCostsNothing) {
  for (const ActivationKind kind :
       {ActivationKind::quadratic, ActivationKind::quadratic_barrier, ActivationKind::smooth_l1,
        ActivationKind::smooth_l2, ActivationKind::linear}) {
    const Activation a{kind, {}, {-1, -kUnlimited}, {kUnlimited, 1}, 0.2};
    const double r[] = {0, 0};
    EXPECT_EQ(a.value(r, 2), 0);
  }
}

}  // namespace
}  // namespace conddp
