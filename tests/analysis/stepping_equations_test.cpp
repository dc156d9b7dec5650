// Step equations of the solver, compared with those of the certificate.
#include "analysis/contact/stepping_equations.hpp"

#include <gtest/gtest.h>

#include "analysis/contact/contact_motion.hpp"
#include "ocp/residuals/stepping_residual.hpp"
#include "support/block_on_slides.hpp"
#include "support/stepping_robot.hpp"

namespace conddp {
namespace {

constexpr double kStep = 0.04;

ShootingProblem one_step(const std::shared_ptr<const SteppingSystem>& system,
                         std::vector<double> start) {
  auto model = std::make_shared<KnotModel>(system, Integrator::semi_implicit_euler);
  auto end = std::make_shared<KnotModel>(system, Integrator::none);
  return {std::move(start), {{"step", model, {kStep}, {kStep}, {}}}, {"end", end, {0}, {1}, {}}};
}

struct Kind {
  SteppingScheme scheme;
  bool floating, planar;
  FrictionModel friction;
};

TEST(SteppingEquations, MatchTheSolver) {
  constexpr auto kEuler = SteppingScheme::backward_euler;
  constexpr auto kMidpoint = SteppingScheme::variational_midpoint;
  constexpr auto kPyramid = FrictionModel::polyhedron;
  constexpr auto kCone = FrictionModel::cone;
  for (const auto& [scheme, floating, planar, friction] :
       {Kind{kEuler, false, true, kPyramid}, Kind{kEuler, true, true, kPyramid},
        Kind{kEuler, true, false, kPyramid}, Kind{kEuler, false, false, kCone},
        Kind{kMidpoint, false, true, kPyramid}, Kind{kMidpoint, false, false, kCone}}) {
    const auto system = stepping_robot(planar, scheme, friction, floating);
    const int n = system->nv();
    RandomNumbers random(11);
    std::vector<double> start = system->manifold().neutral(), off(system->ndx());
    for (double& x : off) x = random.uniform(-1, 1);
    system->manifold().integrate(start.data(), off.data(), start.data());
    const ShootingProblem problem = one_step(system, start);
    Trajectory trajectory = problem.create_trajectory();
    trajectory.x(0) = Eigen::Map<const Eigen::VectorXd>(start.data(), system->nx());
    for (double& w : trajectory.u(0)) w = random.uniform(-2, 2);
    const auto a = trajectory.u(0).segment(system->layout().acceleration, n);
    const Eigen::VectorXd v = trajectory.x(0).tail(n) + kStep * a;
    std::vector<double> step(2 * n);
    for (int i = 0; i < n; ++i) {
      step[i] = kStep * v[i];
      step[n + i] = kStep * a[i];
    }
    system->manifold().integrate(start.data(), step.data(), trajectory.x(1).data());

    const std::optional<ContactMotion> motion = contact_motion(problem, trajectory);
    ASSERT_TRUE(motion);
    const std::vector<double> applied = motion->plant.applied(motion->u[0].data());
    const StepStart from{.q = motion->q[0],
                         .v = motion->v[0],
                         .applied = Eigen::Map<const Eigen::VectorXd>(applied.data(), n),
                         .h = kStep};
    const Eigen::VectorXd impulse =
        stepping_residual(motion->plant, from, motion->v[1], motion->forces[0]);

    const auto residual = stepping_residual(system, system->ndx());
    const auto data = system->create_data(double{});
    Eigen::VectorXd rows(residual->size());
    residual->evaluate({trajectory.x(0).data(), trajectory.u(0).data(), &kStep, *data},
                       rows.data());
    EXPECT_GT(impulse.cwiseAbs().maxCoeff(), 0.01);
    EXPECT_LT((kStep * rows.head(n) - impulse).cwiseAbs().maxCoeff(), 1e-11);
  }
}

/// Block on slides, masses of 4, 3, and 2 kg. The midpoint scheme has M (v⁺ − v) + h (damping of
/// the mean velocity + weight − applied); the other scheme has the full damping at the end.
TEST(SteppingEquations, MidpointsAverageBothResistances) {
  ContactPlant plant{.robot = testing::block_on_slides()};
  plant.damping = {2, 3, 5};
  const Eigen::Vector3d mass(4, 3, 2), damping(2, 3, 5), weight(0, 0, 2 * 9.81);
  const StepStart start{.q = Eigen::Vector3d(0.1, 0.2, 0.3),
                        .v = Eigen::Vector3d(1, -2, 3),
                        .applied = Eigen::Vector3d(0.5, 7, -4),
                        .h = kStep};
  const Eigen::Vector3d v(2, 0.5, -1);
  for (const SteppingScheme scheme :
       {SteppingScheme::backward_euler, SteppingScheme::variational_midpoint}) {
    plant.contacts.scheme = scheme;
    const Eigen::Vector3d resisted =
        scheme == SteppingScheme::backward_euler ? v : Eigen::Vector3d(0.5 * (v + start.v));
    const Eigen::Vector3d expected =
        mass.cwiseProduct(v - start.v) +
        kStep * (damping.cwiseProduct(resisted) + weight - start.applied);
    const Eigen::VectorXd found = stepping_residual(plant, start, v, StepForces(plant.contacts));
    EXPECT_LT((found - expected).norm(), 1e-12) << static_cast<int>(scheme);
  }
}

TEST(ImpulseScale, MatchesTheWeight) {
  const auto robot = std::make_shared<RobotModel>(random_robot(7, {.joints = 3}));
  robot->gravity = {0.3, 0, -0.4};
  ContactPlant plant{.robot = robot};
  EXPECT_NEAR(impulse_scale(plant, 0.02), 0.02 * robot->total_mass() * 0.5, 1e-14);
  robot->gravity = {0, 0, 0};
  EXPECT_NEAR(impulse_scale(plant, 0.02), 0.02 * robot->total_mass() * 9.81, 1e-13);
  for (Joint& joint : robot->joints) joint.inertia = Inertia<double>::zero();
  EXPECT_NEAR(impulse_scale(plant, 1), 9.81e-9, 1e-20);
}

TEST(StepForces, AreFiniteIfAllPartsAre) {
  const auto system = stepping_robot(false);
  const StepForces zero(system->contacts());
  EXPECT_TRUE(zero.finite());
  for (int part = 0; part < 4; ++part) {
    StepForces forces = zero;
    (part == 0   ? forces.contact(2, 1)
     : part == 1 ? forces.stop_lower[0]
     : part == 2 ? forces.stop_upper[1]
                 : forces.friction[0]) = std::numeric_limits<double>::infinity();
    EXPECT_FALSE(forces.finite()) << part;
  }
}

TEST(ContactMotion, HasPassiveForcesAndBoundsOfItsRobot) {
  const auto robot = std::make_shared<RobotModel>(random_robot(7, {.joints = 3}));
  const std::vector<double> damping = {0.5, 1.5, 2.5}, friction = {2, 3, 4};
  for (int i = 0; i < 3; ++i) {
    robot->joints[i].damping = damping[i];
    robot->joints[i].friction = friction[i];
  }
  for (const bool damped : {false, true})
    for (const bool rubbed : {false, true}) {
      ImplicitContacts contacts;
      contacts.stops = {{1, -1, 2}};
      const auto system = std::make_shared<SteppingSystem>(
          std::make_shared<MultibodySystem>(robot, Actuation::full(*robot),
                                            PassiveForces{damped, rubbed, 0.25}),
          contacts);
      auto model = std::make_shared<KnotModel>(system, Integrator::semi_implicit_euler);
      std::vector<double> lower(system->nu()), upper(system->nu());
      for (int i = 0; i < system->nu(); ++i) {
        lower[i] = -1 - i;
        upper[i] = 2 + i;
      }
      model->set_control_bounds(lower, upper);
      auto end = std::make_shared<KnotModel>(system, Integrator::none);
      const ShootingProblem problem({1, 2, 3, 4, 5, 6}, {{"step", model, {0.1, 0.2}, {1, 1}, {}}},
                                    {"end", end, {0}, {1}, {}});
      const auto motion = contact_motion(problem, problem.create_trajectory());
      ASSERT_TRUE(motion);
      EXPECT_EQ(motion->plant.damping, damped ? damping : std::vector<double>{});
      EXPECT_EQ(motion->plant.smooth_friction, rubbed ? friction : std::vector<double>{});
      EXPECT_EQ(motion->plant.friction_velocity, 0.25);
      EXPECT_EQ(motion->u_lower, Eigen::Vector3d(-1, -2, -3));
      EXPECT_EQ(motion->u_upper, Eigen::Vector3d(2, 3, 4));
      EXPECT_EQ(motion->h, (std::vector<double>{0.1, 0.2}));
      EXPECT_EQ(motion->first_knot, 0);
      ASSERT_EQ(motion->q.size(), 3u);
      EXPECT_EQ(motion->q[2], Eigen::Vector3d(1, 2, 3));
      EXPECT_EQ(motion->v[0], Eigen::Vector3d(4, 5, 6));
      EXPECT_EQ(motion->u.size(), 2u);
    }
}

}  // namespace
}  // namespace conddp
