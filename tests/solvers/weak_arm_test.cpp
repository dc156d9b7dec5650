// A hanging arm lifts its hand above its shoulder with motors too weak to hold it outstretched. It
// must swing, with changing sets of active bounds. The arm is that of docs/example.
#include <gtest/gtest.h>

#include "ocp/residuals/residuals.hpp"
#include "robot/urdf/urdf.hpp"
#include "solvers/strategies/registry.hpp"
#include "spatial/lane.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {
namespace {

constexpr const char* kArm = R"(<robot name="arm">
  <link name="stand"/>
  <link name="upper"><inertial><origin xyz="0 0 -0.25"/><mass value="1"/>
    <inertia ixx="0.02" iyy="0.02" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="fore"><inertial><origin xyz="0 0 -0.2"/><mass value="0.8"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.0005" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="hand"/>
  <joint name="shoulder" type="continuous"><parent link="stand"/><child link="upper"/>
    <axis xyz="0 1 0"/><limit effort="5" velocity="100"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="fore"/>
    <origin xyz="0 0 -0.5"/><axis xyz="0 1 0"/><limit effort="5" velocity="100"/></joint>
  <joint name="wrist" type="fixed"><parent link="fore"/><child link="hand"/>
    <origin xyz="0 0 -0.4"/></joint>
</robot>)";

Phase phase(std::shared_ptr<const KnotModel> model, int knots, double dt, double cost_scale,
            const std::vector<double>& parameters) {
  Phase phase{.name = "all",
              .model = std::move(model),
              .dt = std::vector<double>(knots, dt),
              .cost_scale = std::vector<double>(knots, cost_scale),
              .parameters = {}};
  for (int k = 0; k < knots; ++k)
    phase.parameters.insert(phase.parameters.end(), parameters.begin(), parameters.end());
  return phase;
}

TEST(WeakArm, SwingsUpWithNearlyFreeEffort) {
  if (kLaneWidth < 4) GTEST_SKIP() << "two lanes compare a step with fewer others";
  UrdfResult urdf = parse_urdf(kArm, "arm");
  ASSERT_TRUE(urdf.model);
  const auto robot = std::make_shared<const RobotModel>(std::move(*urdf.model));
  const auto arm = std::make_shared<const MultibodySystem>(robot, Actuation::full(*robot));
  const auto moving = std::make_shared<KnotModel>(arm, Integrator::semi_implicit_euler);
  moving->add_cost("effort", control_residual(moving->ndx(), moving->nu()), {});
  moving->add_cost("speed", coordinate_residual(arm->manifold(), {2, 3}), {});
  moving->set_control_bounds(arm->control_lower(), arm->control_upper());
  const auto end = std::make_shared<KnotModel>(arm, Integrator::none);
  end->add_cost("hand", frame_position_residual(arm, robot->find_frame("hand").value()), {});
  end->add_cost("rest", coordinate_residual(arm->manifold(), {2, 3}), {});
  const double dt = 0.02;
  const ShootingProblem problem({0, 0, 0, 0},
                                {phase(moving, 150, dt, dt, {0, 0, 1e-3, /**/ 0, 0, 1e-2})},
                                phase(end, 1, 0, 1, {0.3, 0, 0.7, 1e4, /**/ 0, 0, 1e1}));
  const SolveResult result =
      solve(problem, "box_fddp", {.max_iterations = 200}, problem.create_trajectory());
  EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
  EXPECT_EQ(result.residuals.constraint, 0);
  EXPECT_LT(result.cost, 0.2);  // a hand 1 cm off would cost 0.5
}

}  // namespace
}  // namespace conddp
