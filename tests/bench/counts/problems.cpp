#include "problems.hpp"

#include "ocp/residuals/residuals.hpp"
#include "robot/urdf/urdf.hpp"
#include "support/source_tree.hpp"
#include "systems/closed_forms/catalogue.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {
namespace {

constexpr int kKnots = 16;
/// Makes rows and torques active along the swings.
constexpr double kWeakTorque = 60, kSlippery = 0.2;

using Angles = std::map<std::string, double>;  // by joint

std::shared_ptr<MultibodySystem> system_of(const std::string& name, UrdfOptions::Base base) {
  const auto urdf =
      load_urdf(source_tree().string() + "/problems/robots/" + name + ".urdf", {.base = base});
  const auto robot = std::make_shared<const RobotModel>(urdf.model.value());
  return std::make_shared<MultibodySystem>(robot, Actuation::full(*robot));
}

int frame_of(const MultibodySystem& system, const std::string& name) {
  return system.robot().find_frame(name).value();
}

/// State at rest with the floating base at this height.
std::vector<double> state_of(const MultibodySystem& system, double height, const Angles& pose) {
  std::vector<double> x = system.manifold().neutral();
  if (height > 0) x[2] = height;
  const auto& joints = system.robot().joints;
  for (std::size_t j = 0; j < joints.size(); ++j)
    if (const auto at = pose.find(joints[j].name); at != pose.end())
      x[system.position_index(static_cast<int>(j)).value()] = at->second;
  return x;
}

/// Costs and constraints of a model and the parameters shared by all its knots.
class PhaseMaker {
 public:
  PhaseMaker(const std::shared_ptr<const System>& system, Integrator integrator)
      : robot_(system, system->as_multibody()),
        model_(std::make_shared<KnotModel>(system, integrator)) {
    if (robot_ && integrator != Integrator::none)
      model_->set_control_bounds(robot_->actuation().lower, robot_->actuation().upper);
  }

  void add(const char* name, std::shared_ptr<const Residual> residual,
           const std::vector<double>& reference, double weight, Activation activation = {}) {
    model_->add_cost(name, std::move(residual), std::move(activation));
    parameters_.insert(parameters_.end(), reference.begin(), reference.end());
    parameters_.push_back(weight);
  }
  void add_posture(const std::vector<double>& x, double weight) {
    add("posture", state_residual(model_->manifold()), x, weight);
  }
  void add_effort() {
    add("effort", control_residual(model_->ndx(), model_->nu()),
        std::vector<double>(model_->nu(), 0.0), 1e-3);
  }
  void add_cones(const LinearCone& cone) {
    for (int i = 0; i < robot_->contacts().count(); ++i)
      add("cone", contact_cone_residual(robot_, i, model_->ndx(), cone), {}, 10,
          {.kind = ActivationKind::quadratic_barrier, .lower = cone.lower, .upper = cone.upper});
  }
  void constrain(const char* name, std::shared_ptr<const Residual> residual,
                 const std::vector<double>& reference, const std::vector<double>& lower,
                 const std::vector<double>& upper) {
    model_->add_constraint(make_constraint(name, std::move(residual), ConstraintKind::bounds));
    for (const auto* numbers : {&reference, &lower, &upper})
      parameters_.insert(parameters_.end(), numbers->begin(), numbers->end());
    parameters_.push_back(1);  // switched on
  }
  void constrain_cones(const LinearCone& cone) {
    for (int i = 0; i < robot_->contacts().count(); ++i)
      constrain("cone", contact_cone_residual(robot_, i, model_->ndx(), cone), {}, cone.lower,
                cone.upper);
  }
  void bound_controls(double largest) {
    model_->set_control_bounds(std::vector<double>(model_->nu(), -largest),
                               std::vector<double>(model_->nu(), largest));
  }

  Phase make(int knots, double dt) const {
    Phase phase{.name = "phase",
                .model = model_,
                .dt = std::vector<double>(knots, dt),
                .cost_scale = std::vector<double>(knots, dt > 0 ? dt : 1),
                .parameters = {}};
    for (int k = 0; k < knots; ++k)
      phase.parameters.insert(phase.parameters.end(), parameters_.begin(), parameters_.end());
    return phase;
  }
  const std::shared_ptr<const MultibodySystem>& system() const { return robot_; }
  int ndx() const { return model_->ndx(); }

 private:
  std::shared_ptr<const MultibodySystem> robot_;  ///< null for other systems
  std::shared_ptr<KnotModel> model_;
  std::vector<double> parameters_;
};

Phase rest_at(const std::shared_ptr<const MultibodySystem>& system, const std::vector<double>& x) {
  PhaseMaker end(system, Integrator::none);
  end.add_posture(x, 10);
  return end.make(1, 0);
}

/// The quadruped's swings; `finish` adds cones to a phase.
template <class Finish>
ShootingProblem diagonal_swings(const Finish& finish) {
  const auto system = system_of("quadruped", UrdfOptions::Base::floating);
  Angles pose;
  for (const char* leg : {"LF", "RF", "LH", "RH"}) {
    const double bend = leg[1] == 'F' ? 0.75 : -0.75;
    pose[std::string(leg) + "_HAA"] = -0.2;
    pose[std::string(leg) + "_HFE"] = bend;
    pose[std::string(leg) + "_KFE"] = -2 * bend;
  }
  const std::vector<double> standing = state_of(*system, 0.57, pose);
  const auto swing = [&](const std::vector<std::string>& on, const std::vector<std::string>& up) {
    std::vector<Contact> contacts;
    for (const std::string& foot : on)
      contacts.push_back({.name = foot, .frame = frame_of(*system, foot), .kd = 50});
    PhaseMaker phase(system->with_contacts(contacts), Integrator::semi_implicit_euler);
    phase.add_posture(standing, 10);
    phase.add_effort();
    finish(phase);
    for (const std::string& foot : up) {
      const double x = foot[1] == 'f' ? 0.37 : -0.37, y = foot[0] == 'l' ? 0.32 : -0.32;
      phase.add("swing", frame_position_residual(phase.system(), frame_of(*system, foot)),
                {x, y, 0.04}, 1e3);
    }
    return phase.make(kKnots / 2, 0.02);
  };
  return ShootingProblem(standing,
                         {swing({"lf_foot", "rh_foot"}, {"rf_foot", "lh_foot"}),
                          swing({"rf_foot", "lh_foot"}, {"lf_foot", "rh_foot"})},
                         rest_at(system, standing));
}

}  // namespace

ShootingProblem counted_trot() {
  return diagonal_swings([](PhaseMaker& phase) {
    phase.add_cones(friction_pyramid({}, 4, false, {0, 0, 1}));
  });
}

ShootingProblem counted_grip() {
  return diagonal_swings([](PhaseMaker& phase) {
    phase.bound_controls(kWeakTorque);
    phase.constrain_cones(friction_pyramid({.friction = kSlippery}, 4, false, {0, 0, 1}));
  });
}

ShootingProblem counted_swing() {
  const std::vector<double> upright{0, 3.141592653589793, 0, 0}, zero(4, 0.0);
  const std::shared_ptr<const System> system = cartpole({});
  const auto state = state_residual(system->manifold());
  PhaseMaker phase(system, Integrator::rk3), end(system, Integrator::none);
  phase.add("state", state, upright, 0.01);
  phase.add_effort();
  phase.bound_controls(3);
  end.add("state", state, upright, 100);
  end.constrain("upright", state, upright, zero, zero);
  return ShootingProblem(zero, {phase.make(50, 0.1)}, end.make(1, 0));
}

ShootingProblem counted_flight() {
  const std::shared_ptr<const System> system = quadrotor({});
  const std::vector<double> start = system->manifold().neutral();
  std::vector<double> goal = start;
  goal[0] = goal[2] = 1;
  const auto state = state_residual(system->manifold());
  PhaseMaker phase(system, Integrator::rk4), end(system, Integrator::none);
  phase.add("state", state, goal, 1);
  phase.add_effort();
  phase.bound_controls(12);
  end.add("state", state, goal, 10);
  return ShootingProblem(start, {phase.make(kKnots, 0.05)}, end.make(1, 0));
}

ShootingProblem counted_reach() {
  const auto system = system_of("arm7", UrdfOptions::Base::fixed);
  const std::vector<double> ready =
      state_of(*system, 0, {{"joint_2", 0.4}, {"joint_4", -1.2}, {"joint_6", 1.54}});
  PhaseMaker phase(system, Integrator::semi_implicit_euler), end(system, Integrator::none);
  phase.add_posture(ready, 1);
  phase.add("effort", control_gravity_residual(system, phase.ndx()), {}, 1e-3);
  end.add("tool", frame_placement_residual(system, frame_of(*system, "tool")),
          {0.35, 0.45, 0.4, 1, 0, 0, 0}, 1e3);
  end.add_posture(ready, 1);
  return ShootingProblem(ready, {phase.make(kKnots, 0.02)}, end.make(1, 0));
}

ShootingProblem counted_squat() {
  const auto system = system_of("biped", UrdfOptions::Base::floating);
  Angles pose{{"torso_pitch", 0.1}};
  for (const char* side : {"l", "r"}) {
    const std::string leg(side);
    pose[leg + "_hip_pitch"] = pose[leg + "_ankle_pitch"] = -0.4;
    pose[leg + "_knee"] = 0.8;
    pose[leg + "_elbow"] = -0.6;
  }
  const std::vector<double> standing = state_of(*system, 0.7832, pose);
  std::vector<Contact> soles;
  for (const char* sole : {"l_sole", "r_sole"})
    soles.push_back(
        {.name = sole, .frame = frame_of(*system, sole), .kind = ContactKind::surface, .kd = 50});
  PhaseMaker phase(system->with_contacts(soles), Integrator::semi_implicit_euler);
  phase.add_posture(standing, 1);
  phase.add_effort();
  phase.add_cones(wrench_cone({.min_normal = 20}, 0.09, 0.04, true));
  phase.add("height", com_position_residual(phase.system()), {0.03, 0, 0.65}, 1e3);
  return ShootingProblem(standing, {phase.make(kKnots, 0.02)}, rest_at(system, standing));
}

const std::map<std::string, ShootingProblem (*)()>& counted_problems() {
  static const std::map<std::string, ShootingProblem (*)()> problems{
      {"trot", counted_trot},   {"reach", counted_reach},   {"squat", counted_squat},
      {"swing", counted_swing}, {"flight", counted_flight}, {"grip", counted_grip}};
  return problems;
}

}  // namespace conddp
