#include <gtest/gtest.h>

#include "support/knot_case.hpp"
#include "support/mimic_robot.hpp"
#include "support/named_residuals.hpp"
#include "support/sizes.hpp"

namespace conddp {
namespace {

std::shared_ptr<const MultibodySystem> system_of(const RobotModel& model) {
  return std::make_shared<MultibodySystem>(std::make_shared<RobotModel>(model),
                                           Actuation::full(model), PassiveForces{true, true, 0.4});
}

TEST(MimicResiduals, BlocksNameReducedColumnsAscendingAndOnce) {
  for (const auto& [name, model] : mimic_robots()) {
    const auto system = system_of(model);
    const KnotModel shape(system, Integrator::semi_implicit_euler);
    for (const auto& [residual_name, residual] : named_residuals(system, shape))
      for (const RowBlock& block : residual->blocks())
        for (std::size_t i = 0; i < block.columns.size(); ++i) {
          EXPECT_GE(block.columns[i], 0);
          EXPECT_LT(block.columns[i], shape.nz()) << name << ' ' << residual_name;
          if (i > 0) {
            EXPECT_LT(block.columns[i - 1], block.columns[i]) << name << ' ' << residual_name;
          }
        }
  }
}

TEST(MimicResiduals, GradientsAndDynamicsMatchDualNumbers) {
  RandomNumbers random(71);
  for (const auto& [name, robot] : mimic_robots()) {
    const auto system = system_of(robot);
    for (const bool memory : {false, true}) {
      const KnotModel shape(step_with(system, Integrator::semi_implicit_euler, memory));
      for (const auto& [residual_name, residual] : named_residuals(system, shape)) {
        auto model =
            std::make_shared<KnotModel>(step_with(system, Integrator::semi_implicit_euler, memory));
        model->add_cost("cost", residual, {});
        const KnotCase c = make_case(residual_name, model, random);
        KnotWorkspace<double> work(*model);
        model->differentiate(
            KnotInput<double>{c.x.data(), c.u.data(), c.parameters.data(), c.dt, c.dt}, work, true);
        double scale = 1;
        for (double g : work.gradient) scale = std::max(scale, std::abs(g));
        const int rows = model->jacobian_rows();
        for (int d = 0; d < model->nz(); d += kDirectionStride) {
          const DirectionalDerivative expected = directional_derivative(c, d);
          EXPECT_NEAR(work.gradient[d], expected.cost, 1e-10 * scale)
              << name << ' ' << residual_name << " direction " << d;
          for (int i = 0; i < rows; ++i) {
            const double next = expected.next[model->ndx() - rows + i];
            EXPECT_NEAR(work.F()[d * rows + i], next, 1e-10 * (1 + std::abs(next)))
                << name << ' ' << residual_name << " direction " << d;
          }
        }
      }
    }
  }
}

TEST(MimicResiduals, TerminalNodesSeeTheFullRobot) {
  RandomNumbers random(72);
  for (const auto& [name, robot] : mimic_robots()) {
    const auto system = system_of(robot);
    const RobotState state = random_mimic_state(robot, random);
    std::vector<double> x = system->reduce_configuration(state.q);
    const std::vector<double> v = system->reduce_velocity(state.v);
    x.insert(x.end(), v.begin(), v.end());
    const auto data = system->create_data(double{});
    system->update_kinematics(x.data(), *data);
    RobotData<double> expected(robot);
    update_placements(robot, state.q.data(), expected);
    update_velocities(robot, state.v.data(), expected);
    update_composite_inertias(robot, expected);
    const std::vector<double> zero(7, 0.0);
    for (int f = 0; f < static_cast<int>(robot.frames.size()); ++f) {
      double r[6];
      const ResidualInput<double> in{x.data(), nullptr, zero.data(), *data};
      frame_position_residual(system, f)->evaluate(in, r);
      const Vector3<double> p = frame_placement(robot, expected, f).p;
      for (int i = 0; i < 3; ++i) EXPECT_NEAR(r[i], p[i], 1e-12) << name;
      frame_velocity_residual(system, f, FrameAxes::local)->evaluate(in, r);
      const Motion<double> twist = frame_velocity(robot, expected, f, FrameAxes::local);
      for (int i = 0; i < 6; ++i) EXPECT_NEAR(r[i], twist[i], 1e-11) << name;
    }
    double r[3];
    com_position_residual(system)->evaluate({x.data(), nullptr, zero.data(), *data}, r);
    const Vector3<double> com = center_of_mass(robot, expected);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(r[i], com[i], 1e-12) << name;
  }
}

TEST(MimicResiduals, ControlGravityAtRestMatchesInverseDynamics) {
  // Without wrenches: B u − g = Gᵀ M G a, here from inverse dynamics of the full robot.
  RandomNumbers random(73);
  for (auto [name, robot] : mimic_robots()) {
    robot.wrenches.clear();
    const auto system = system_of(robot);
    RobotState state = random_mimic_state(robot, random);
    std::vector<double> x = system->reduce_configuration(state.q);
    x.resize(system->nx(), 0.0);
    const std::vector<double> u = random.numbers(system->nu(), 2);
    const auto data = system->create_data(double{});
    system->evaluate(x.data(), u.data(), *data);
    const auto residual = control_gravity_residual(system, system->ndx());
    std::vector<double> r(residual->size());
    residual->evaluate({x.data(), u.data(), nullptr, *data}, r.data());
    const auto& robot_data = static_cast<MultibodySystem::Data<double>&>(*data).robot;
    const std::vector<double> zero(robot.nv, 0.0);
    RobotData<double> full(robot);
    inverse_dynamics(robot, state.q.data(), zero.data(), robot_data.acceleration.data(), full);
    const std::vector<double> tau(full.tau.begin(), full.tau.end());
    inverse_dynamics(robot, state.q.data(), zero.data(), zero.data(), full);
    const std::vector<double> gravity(full.tau.begin(), full.tau.end());
    const std::vector<double> all = system->reduce_force(tau);
    const std::vector<double> weight = system->reduce_force(gravity);
    const std::vector<int> rows = system->actuated_rows();
    for (std::size_t i = 0; i < rows.size(); ++i)
      EXPECT_NEAR(r[i], all[rows[i]] - weight[rows[i]], 1e-9) << name;
  }
}

}  // namespace
}  // namespace conddp
