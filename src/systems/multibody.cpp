#include "systems/multibody.hpp"

#include <algorithm>
#include <stdexcept>

namespace conddp {
namespace {

StateManifold state_space(const RobotModel& robot) {
  StateManifold m;
  for (const Joint& joint : robot.joints)
    m.append(
        joint.type == JointType::floating ? StateManifold::Part::se3 : StateManifold::Part::flat,
        1);
  m.append(StateManifold::Part::flat, robot.nv);
  return m;
}

std::vector<Column> state_names(const RobotModel& robot) {
  std::vector<Column> q, v;
  for (const Joint& joint : robot.joints) {
    if (joint.type == JointType::floating) {
      for (const char* axis : {"x", "y", "z"}) {
        q.push_back({joint.name + "/" + axis, "m"});
        v.push_back({joint.name + "/v" + axis, "m/s"});
      }
      for (const char* part : {"qx", "qy", "qz", "qw"}) q.push_back({joint.name + "/" + part, "1"});
      for (const char* axis : {"wx", "wy", "wz"}) v.push_back({joint.name + "/" + axis, "rad/s"});
      continue;
    }
    const bool turns = joint.type == JointType::revolute;
    q.push_back({"q/" + joint.name, turns ? "rad" : "m"});
    v.push_back({"v/" + joint.name, turns ? "rad/s" : "m/s"});
  }
  q.insert(q.end(), v.begin(), v.end());
  return q;
}

/// Appends a control that acts as one joint's generalised force.
void add_joint(const RobotModel& model, int index, Actuation& actuation) {
  const Joint& joint = model.joints[index];
  if (joint.type == JointType::floating)
    throw std::invalid_argument("joint " + joint.name + " is a floating base: use thrusters");
  actuation.B.resize(actuation.B.size() + model.nv, 0.0);
  actuation.B[actuation.nu * model.nv + joint.v] = 1;
  ++actuation.nu;
  actuation.columns.push_back({"u/" + joint.name, joint.type == JointType::revolute ? "Nm" : "N"});
  actuation.lower.push_back(-joint.max_effort);
  actuation.upper.push_back(joint.max_effort);
}

/// 1/(1 + exp(2 v/scale)), so that tanh(v/scale) = 1 − 2·logistic; clamped where it saturates to
/// rounding, which keeps exp finite.
template <class S>
S logistic(const S& v, double scale) {
  return S(1.0) / (S(1.0) + exp(max(S(-40.0), min(S(40.0), v * S(2 / scale)))));
}

}  // namespace

Actuation Actuation::full(const RobotModel& model) {
  Actuation actuation;
  for (int i = 0; i < model.joint_count(); ++i)
    if (model.joints[i].type != JointType::floating) add_joint(model, i, actuation);
  return actuation;
}

Actuation Actuation::joints(const RobotModel& model, const std::vector<std::string>& names) {
  return thrusters(model, {}, names);
}

Actuation Actuation::thrusters(const RobotModel& model, const std::vector<Thruster>& thrusters,
                               const std::vector<std::string>& joint_names) {
  Actuation actuation;
  for (const Thruster& thruster : thrusters) {
    const Frame& frame = model.frames[thruster.frame];
    if (frame.joint < 0 || model.joints[frame.joint].type != JointType::floating)
      throw std::invalid_argument("thruster " + thruster.name + ": frame " + frame.name +
                                  " is not fixed to a floating base");
    const Vector3<double>& d = thruster.direction;
    const Force<double> wrench = act(frame.placement, Force<double>{d, thruster.torque_ratio * d});
    actuation.B.resize(actuation.B.size() + model.nv, 0.0);
    for (int k = 0; k < 6; ++k)
      actuation.B[actuation.nu * model.nv + model.joints[frame.joint].v + k] = wrench[k];
    ++actuation.nu;
    actuation.columns.push_back({"u/" + thruster.name, "N"});
    actuation.lower.push_back(thruster.lower);
    actuation.upper.push_back(thruster.upper);
  }
  for (const std::string& name : joint_names) {
    const auto index = model.find_joint(name);
    if (!index) throw std::invalid_argument("no joint is called " + name);
    add_joint(model, *index, actuation);
  }
  return actuation;
}

MultibodySystem::MultibodySystem(std::shared_ptr<const RobotModel> robot, Actuation actuation,
                                 PassiveForces passive)
    : SystemBase(SystemKind::second_order, state_space(*robot), actuation.nu),
      robot_(std::move(robot)),
      actuation_(std::move(actuation)),
      passive_(passive) {
  state_columns_ = state_names(*robot_);
  control_columns_ = actuation_.columns;
  control_lower_ = actuation_.lower;
  control_upper_ = actuation_.upper;
  for (int c = 0; c < nu_; ++c)
    for (int r = 0; r < robot_->nv; ++r)
      if (const double value = actuation_.B[c * robot_->nv + r]; value != 0)
        entries_.push_back({r, c, value});
}

std::vector<int> MultibodySystem::actuated_rows() const {
  std::vector<int> rows;
  for (const Entry& e : entries_) rows.push_back(e.row);
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  return rows;
}

template <class S>
MultibodySystem::Data<S>::Data(const MultibodySystem& system)
    : robot(system.robot()),
      force(system.nv(), S(0.0)),
      gravity(system.nv(), S(0.0)),
      gravity_q(system.nv() * system.nv(), S(0.0)) {}

template <class S>
void MultibodySystem::applied_forces(const S* v, const S* u, Data<S>& data) const {
  std::fill(data.force.begin(), data.force.end(), S(0.0));
  for (const Entry& e : entries_) data.force[e.row] += u[e.column] * S(e.value);
  if (!passive_.damping && !passive_.friction) return;
  for (const Joint& joint : robot_->joints) {
    if (joint.type == JointType::floating) continue;
    if (passive_.damping) data.force[joint.v] -= v[joint.v] * S(joint.damping);
    if (passive_.friction && joint.friction > 0) {
      data.force[joint.v] -=
          S(joint.friction) * (S(1.0) - S(2.0) * logistic(v[joint.v], passive_.friction_velocity));
    }
  }
}

template <class S>
void MultibodySystem::evaluate_as(const S* x, const S* u, Data<S>& data) const {
  const S* v = x + robot_->nq;
  applied_forces(v, u, data);
  forward_dynamics(*robot_, x, v, data.force.data(), data.robot);
  std::copy(data.robot.acceleration.begin(), data.robot.acceleration.end(), data.f.begin());
}

template <class S>
void MultibodySystem::differentiate_as(const S* x, const S* u, Data<S>& data) const {
  evaluate_as(x, u, data);
  const int n = robot_->nv;
  const S* v = x + robot_->nq;
  inverse_dynamics_derivatives(*robot_, v, data.robot);
  for (int i = 0; i < n * n; ++i) {
    data.fx[i] = -data.robot.tau_q[i];
    data.fx[n * n + i] = -data.robot.tau_v[i];
  }
  std::fill(data.fu.begin(), data.fu.end(), S(0.0));
  for (const Entry& e : entries_) data.fu[e.column * n + e.row] = S(e.value);
  if (passive_.damping || passive_.friction)
    for (const Joint& joint : robot_->joints) {
      if (joint.type == JointType::floating) continue;
      S& slope = data.fx[(n + joint.v) * n + joint.v];
      if (passive_.damping) slope -= S(joint.damping);
      if (passive_.friction && joint.friction > 0) {
        const S h = logistic(v[joint.v], passive_.friction_velocity);
        slope -= S(4 * joint.friction / passive_.friction_velocity) * (S(1.0) - h) * h;
      }
    }
  for (int c = 0; c < 2 * n; ++c) solve_mass_matrix(*robot_, data.robot, &data.fx[c * n]);
  for (int c = 0; c < nu_; ++c) solve_mass_matrix(*robot_, data.robot, &data.fu[c * n]);
}

template <class S>
void MultibodySystem::update_kinematics_as(const S* x, Data<S>& data) const {
  update_placements(*robot_, x, data.robot);
  update_velocities(*robot_, x + robot_->nq, data.robot);
  update_composite_inertias(*robot_, data.robot);
}

#define CONDDP_INSTANTIATE(S)                                                          \
  template struct MultibodySystem::Data<S>;                                            \
  template void MultibodySystem::evaluate_as(const S*, const S*, Data<S>&) const;      \
  template void MultibodySystem::differentiate_as(const S*, const S*, Data<S>&) const; \
  template void MultibodySystem::update_kinematics_as(const S*, Data<S>&) const;
CONDDP_FOR_EACH_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
