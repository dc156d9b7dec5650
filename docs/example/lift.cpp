// An arm of two joints lifts its hand to a point with motors that cannot hold it outstretched.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <utility>
#include <vector>

#include "conddp/conddp.hpp"

using namespace conddp;

namespace {

constexpr const char* kArm = R"(<?xml version="1.0"?>
<robot name="arm">
  <link name="stand"/>
  <link name="upper">
    <inertial>
      <origin xyz="0 0 -0.25"/>
      <mass value="1"/>
      <inertia ixx="0.02" iyy="0.02" izz="0.001" ixy="0" ixz="0" iyz="0"/>
    </inertial>
  </link>
  <link name="fore">
    <inertial>
      <origin xyz="0 0 -0.2"/>
      <mass value="0.8"/>
      <inertia ixx="0.01" iyy="0.01" izz="0.0005" ixy="0" ixz="0" iyz="0"/>
    </inertial>
  </link>
  <link name="hand"/>
  <joint name="shoulder" type="continuous">
    <parent link="stand"/> <child link="upper"/>
    <axis xyz="0 1 0"/> <limit effort="6" velocity="100"/>
  </joint>
  <joint name="elbow" type="continuous">
    <parent link="upper"/> <child link="fore"/>
    <origin xyz="0 0 -0.5"/> <axis xyz="0 1 0"/> <limit effort="6" velocity="100"/>
  </joint>
  <joint name="wrist" type="fixed">
    <parent link="fore"/> <child link="hand"/> <origin xyz="0 0 -0.4"/>
  </joint>
</robot>)";

/// Knots of one model: `parameters` are the numbers that its costs take at each of them.
Phase phase(const char* name, std::shared_ptr<const KnotModel> model, int knots, double dt,
            double cost_scale, const std::vector<double>& parameters) {
  Phase phase{.name = name, .model = std::move(model)};
  for (int k = 0; k < knots; ++k) {
    phase.dt.push_back(dt);
    phase.cost_scale.push_back(cost_scale);
    phase.parameters.insert(phase.parameters.end(), parameters.begin(), parameters.end());
  }
  return phase;
}

}  // namespace

int main() {
  UrdfResult urdf = parse_urdf(kArm, "arm");
  for (const UrdfProblem& problem : urdf.problems)
    std::fprintf(stderr, "%s\n", problem.message.c_str());
  if (!urdf.model) return 2;
  const auto robot = std::make_shared<const RobotModel>(std::move(*urdf.model));
  const auto arm = std::make_shared<const MultibodySystem>(robot, Actuation::full(*robot));

  // A cost takes its reference and then its weight from every knot, costs in the order in which
  // they were added.
  const auto moving = std::make_shared<KnotModel>(arm, Integrator::semi_implicit_euler);
  moving->add_cost("effort", control_residual(moving->ndx(), moving->nu()), {});
  moving->add_cost("speed", coordinate_residual(arm->manifold(), {2, 3}), {});
  moving->set_control_bounds(arm->control_lower(), arm->control_upper());
  const std::vector<double> effort_and_speed = {0, 0, 1e-2, /**/ 0, 0, 1e-1};

  const int hand = robot->find_frame("hand").value();
  const auto end = std::make_shared<KnotModel>(arm, Integrator::none);
  end->add_cost("hand", frame_position_residual(arm, hand), {});
  end->add_cost("rest", coordinate_residual(arm->manifold(), {2, 3}), {});
  const std::vector<double> lifted_and_at_rest = {0.3, 0, 0.7, 1e3, /**/ 0, 0, 1e1};

  const double dt = 0.02;  // s; running costs are rates, hence scaled by it
  const ShootingProblem problem({0, 0, 0, 0},
                                {phase("move", moving, 150, dt, dt, effort_and_speed)},
                                phase("end", end, 1, 0, 1, lifted_and_at_rest));

  SolverOptions options{.max_iterations = 200};
  options.on_iteration = [](const IterationRecord& row) {
    if (row.iteration % 10 == 0) {
      std::printf("iteration %3d  cost %.6e  stationarity %.1e  step %.3g\n", row.iteration,
                  row.cost, row.stationarity, row.step);
    }
  };
  // A guess without torques: states stand still, which multiple shooting may start from.
  const Trajectory guess = problem.create_trajectory();

  const SolveResult result = solve(problem, "box_fddp", options, guess);
  std::printf("%s after %d iterations: %s\n", to_string(result.status).data(), result.iterations,
              result.message.c_str());

  double largest_torque = 0;
  for (int k = 0; k < problem.knots(); ++k) {
    largest_torque = std::max(largest_torque, result.trajectory.u(k).lpNorm<Eigen::Infinity>());
  }
  const auto final_state = result.trajectory.x(problem.knots());
  std::printf("largest torque %.3f Nm\n", largest_torque);
  std::printf("final shoulder %.4f rad, elbow %.4f rad\n", final_state[0], final_state[1]);
  const Eigen::MatrixXd& gain = result.feedback.K.front();  // of u = u0 + K (x ⊖ x0)
  std::printf("feedback gains: %d x %d a knot\n", static_cast<int>(gain.rows()),
              static_cast<int>(gain.cols()));
  return result.status == SolveStatus::converged ? 0 : 1;
}
