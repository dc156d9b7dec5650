#include "systems/contact/stepping_system.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "robot/dynamics.hpp"
#include "robot/kinematics.hpp"

namespace conddp {
namespace {

int add(std::vector<Column>& columns, std::string name, std::string unit) {
  columns.push_back({std::move(name), std::move(unit)});
  return static_cast<int>(columns.size()) - 1;
}

/// Adds forces and slips along the tangents, named t+, t- in a plane, t1+ … t2- in space.
FrictionIndices add_friction(SteppingLayout& layout, const std::string& prefix, int tangents,
                             const std::string& force_unit, const std::string& slip_unit) {
  FrictionIndices f{.count = 2 * tangents};
  for (int i = 0; i < f.count; ++i) {
    const std::string label =
        (tangents == 1 ? "t" : "t" + std::to_string(1 + i / 2)) + (i % 2 == 0 ? "+" : "-");
    f.force[i] = add(layout.columns, prefix + "/f" + label, force_unit);
    f.slip[i] = add(layout.columns, prefix + "/slip_" + label, slip_unit);
    layout.pairs.emplace_back(f.force[i], f.slip[i]);
  }
  f.gamma = add(layout.columns, prefix + "/slip_speed", slip_unit);
  f.rest = add(layout.columns, prefix + "/friction_left", force_unit);
  layout.pairs.emplace_back(f.gamma, f.rest);
  return f;
}

/// Adds the unknowns of two tangents: first the forces, then the variables that determine them.
ConeIndices add_cone(SteppingLayout& layout, const std::string& prefix) {
  ConeIndices cone{.present = true};
  for (int i = 0; i < 2; ++i)
    cone.force[i] = add(layout.columns, fmt::format("{}/ft{}", prefix, i + 1), "N");
  for (int i = 0; i < 2; ++i)
    cone.use[i] = add(layout.columns, fmt::format("{}/use{}", prefix, i + 1), "");
  cone.speed = add(layout.columns, prefix + "/slip_speed", "m/s");
  cone.rest = add(layout.columns, prefix + "/use_left", "");
  layout.pairs.emplace_back(cone.speed, cone.rest);
  return cone;
}

bool turns(const Joint& joint) { return joint.type == JointType::revolute; }

void add_acceleration(SteppingLayout& layout, const Joint& joint) {
  const std::string name = "a/" + joint.name;
  if (joint.type != JointType::floating) {
    add(layout.columns, name, turns(joint) ? "rad/s²" : "m/s²");
    return;
  }
  for (const char* axis : {"x", "y", "z"}) add(layout.columns, name + "/v" + axis, "m/s²");
  for (const char* axis : {"x", "y", "z"}) add(layout.columns, name + "/w" + axis, "rad/s²");
}

void add_candidate(SteppingLayout& layout, const ContactCandidate& c,
                   const ImplicitContacts& contacts) {
  const std::string prefix = "contact/" + c.name;
  SteppingLayout::Candidate indices;
  indices.force = add(layout.columns, prefix + "/fn", "N");
  indices.gap = add(layout.columns, prefix + "/gap", "m");
  layout.pairs.emplace_back(indices.force, indices.gap);
  // With one tangent, the cone is the pyramid.
  if (c.friction > 0 && contacts.friction == FrictionModel::cone && !contacts.plane)
    indices.cone = add_cone(layout, prefix);
  else if (c.friction > 0)
    indices.friction = add_friction(layout, prefix, contacts.plane ? 1 : 2, "N", "m/s");
  layout.candidates.push_back(indices);
}

/// Adds the lower or upper end of a joint's range, if it is finite.
void add_stop(SteppingLayout& layout, const Joint& joint, const JointStop& stop, bool upper) {
  const double limit = upper ? stop.upper : stop.lower;
  if (!std::isfinite(limit)) return;
  const std::string prefix = "stop/" + joint.name + (upper ? "/upper" : "/lower");
  SteppingLayout::Stop indices{.joint = stop.joint,
                               .position = joint.q,
                               .velocity = joint.v,
                               .upper = upper,
                               .limit = limit};
  indices.force = add(layout.columns, prefix + "/f", turns(joint) ? "Nm" : "N");
  indices.distance = add(layout.columns, prefix + "/distance", turns(joint) ? "rad" : "m");
  layout.pairs.emplace_back(indices.force, indices.distance);
  layout.stops.push_back(indices);
}

void add_joint_friction(SteppingLayout& layout, const Joint& joint) {
  layout.friction_velocities.push_back(joint.v);
  const bool turning = turns(joint);
  layout.frictions.push_back(add_friction(layout, "friction/" + joint.name, 1, turning ? "Nm" : "N",
                                          turning ? "rad/s" : "m/s"));
}

/// An entry of a symmetric matrix stored as its lower triangle, n x n by columns.
template <class S>
const S& symmetric(const AlignedVector<S>& m, int i, int j, int n) {
  return i > j ? m[j * n + i] : m[i * n + j];
}

}  // namespace

SteppingLayout::SteppingLayout(const RobotModel& robot, const std::vector<Column>& actuator_columns,
                               const ImplicitContacts& contacts)
    : actuators(static_cast<int>(actuator_columns.size())),
      acceleration(actuators),
      nv(robot.nv),
      columns(actuator_columns) {
  for (const Joint& joint : robot.joints) add_acceleration(*this, joint);
  for (const ContactCandidate& c : contacts.candidates) add_candidate(*this, c, contacts);
  for (const JointStop& stop : contacts.stops)
    for (const bool upper : {false, true}) add_stop(*this, robot.joints[stop.joint], stop, upper);
  for (const JointFriction& friction : contacts.frictions)
    add_joint_friction(*this, robot.joints[friction.joint]);
}

template <class S>
HalfStep<S>::HalfStep(const RobotModel& robot)
    : position(robot.nq, S(0.0)),
      momentum(robot.nv, S(0.0)),
      load(robot.nv, S(0.0)),
      momentum_q(robot.nv * robot.nv, S(0.0)),
      load_q(robot.nv * robot.nv, S(0.0)),
      nv(robot.nv),
      at(robot),
      along(robot),
      q(robot.nq, Dual<S>(0.0)),
      v(robot.nv, Dual<S>(0.0)),
      rest(robot.nv, Dual<S>(0.0)) {}

/// M̊v = ∂P/∂q v is the force due to the change of M; bias forces are c = M̊v + C.
template <class S>
void update_half_step(const RobotModel& robot, const RobotModel& free, const S* v, bool slopes,
                      HalfStep<S>& half) {
  const int n = half.nv;
  const S* q = half.position.data();
  for (int i = 0; i < n; ++i) {
    half.q[i] = {q[i], v[i]};
    half.v[i] = {v[i], S(0.0)};
  }
  inverse_dynamics(free, half.q.data(), half.rest.data(), half.v.data(), half.along);
  update_placements(robot, q, half.at);
  update_velocities(robot, v, half.at);
  mass_matrix(robot, half.at);
  bias_forces(robot, v, half.at);
  for (int i = 0; i < n; ++i) {
    half.momentum[i] = half.along.tau[i].v;
    half.load[i] = half.at.bias[i] - half.along.tau[i].d;
  }
  if (!slopes) return;
  update_composite_inertias(free, half.along);
  std::copy_n(half.v.begin(), n, half.along.acceleration.begin());
  inverse_dynamics_derivatives(free, half.rest.data(), half.along);
  std::fill_n(half.at.acceleration.begin(), n, S(0.0));
  inverse_dynamics_derivatives(robot, v, half.at);
  for (int i = 0; i < n * n; ++i) {
    half.momentum_q[i] = half.along.tau_q[i].v;
    half.load_q[i] = half.at.tau_q[i] - half.along.tau_q[i].d;
  }
}

SteppingSystem::SteppingSystem(std::shared_ptr<const MultibodySystem> robot,
                               ImplicitContacts contacts)
    : SystemBase(SystemKind::second_order, robot->manifold(), 0),
      robot_(std::move(robot)),
      contacts_(std::move(contacts)),
      layout_(robot_->robot(), robot_->control_columns(), contacts_) {
  for (const StateManifold::Segment& s : manifold().segments())
    if (s.dx < nv()) configurations_.append(s.part, std::min(s.n, nv() - s.dx));
  check_joints();
  for (const ContactCandidate& candidate : contacts_.candidates)
    geometry_.emplace_back(robot_->robot(), candidate, contacts_.plane);
  if (contacts_.scheme == SteppingScheme::variational_midpoint) {
    free_ = robot_->robot();
    free_.gravity = Vector3<double>::zero();
    free_.wrenches.clear();
  }
  nu_ = layout_.size();
  state_columns_ = robot_->state_columns();
  control_columns_ = layout_.columns;
  control_lower_.assign(nu_, -kUnlimited);
  control_upper_.assign(nu_, kUnlimited);
  std::copy(robot_->control_lower().begin(), robot_->control_lower().end(), control_lower_.begin());
  std::copy(robot_->control_upper().begin(), robot_->control_upper().end(), control_upper_.begin());
}

void SteppingSystem::check_joints() const {
  for (const Joint& joint : robot_->robot().joints)
    if (joint.type == JointType::floating &&
        contacts_.scheme == SteppingScheme::variational_midpoint)
      throw std::invalid_argument("the joint '" + joint.name +
                                  "' floats, which the scheme 'variational_midpoint' does not "
                                  "allow: 'backward_euler' does");
  if (!robot_->mimic_map().identity())
    throw std::invalid_argument(
        "a joint mimics another one, which contact-implicit steps do not "
        "allow");
}

template <class S>
SteppingSystem::Data<S>::Data(const SteppingSystem& system)
    : MultibodySystem::Data<S>(system.multibody()),
      end(system.multibody()),
      q(system.nq(), S(0.0)),
      v(system.nv(), S(0.0)),
      motion(system.nv(), S(0.0)),
      motion_q(system.nv() * system.nv(), S(0.0)),
      motion_v(motion_q),
      motion_a(motion_q),
      reach(system.nv(), S(0.0)),
      wrt_q(StateManifold::kBlockSize * system.configurations().curved().size(), S(0.0)),
      wrt_reach(wrt_q) {
  if (system.contacts().scheme == SteppingScheme::variational_midpoint)
    half.emplace(system.multibody().robot());
  for (const CandidateGeometry& geometry : system.geometry())
    candidates.push_back(geometry.create_rows<S>());
}

template <class S>
void SteppingSystem::update_kinematics_as(const S* x, Data<S>& data) const {
  robot_->update_kinematics_as(x, data);
}

template <class S>
void SteppingSystem::evaluate_as(const S* x, const S* w, Data<S>& data) const {
  update_kinematics_as(x, data);
  for (int i = 0; i < nv(); ++i)
    data.f[i] = data.robot.acceleration[i] = w[layout_.acceleration + i];
}

template <class S>
void SteppingSystem::differentiate_as(const S* x, const S* w, Data<S>& data) const {
  evaluate_as(x, w, data);
  std::fill(data.fx.begin(), data.fx.end(), S(0.0));
  std::fill(data.fu.begin(), data.fu.end(), S(0.0));
  for (int i = 0; i < nv(); ++i) data.fu[(layout_.acceleration + i) * nv() + i] = S(1.0);
}

template <class S>
void SteppingSystem::take_step(const S* x, const S* w, const S& h, bool slopes,
                               Data<S>& data) const {
  const S* a = w + layout_.acceleration;
  for (int i = 0; i < nv(); ++i) {
    data.v[i] = x[nq() + i] + h * a[i];
    data.reach[i] = h * data.v[i];
  }
  move_configuration(x, h, slopes, data);
  const RobotModel& model = robot_->robot();
  RobotData<S>& end = data.end.robot;
  update_placements(model, data.q.data(), end);
  update_velocities(model, data.v.data(), end);
  for (std::size_t c = 0; c < geometry_.size(); ++c) {
    if (slopes)
      geometry_[c].differentiate(end, data.candidates[c]);
    else
      geometry_[c].evaluate(end, data.candidates[c]);
  }
  if (data.half)
    variational_midpoint(x, w, h, slopes, data);
  else
    backward_euler(w, h, slopes, data);
}

template <class S>
void SteppingSystem::move_configuration(const S* x, const S& h, bool slopes, Data<S>& data) const {
  if (configurations_.curved().empty()) {
    for (int i = 0; i < nv(); ++i) data.q[i] = x[i] + h * data.v[i];
    return;
  }
  configurations_.integrate(x, data.reach.data(), data.q.data());
  if (slopes)
    configurations_.integrate_jacobians(data.reach.data(), data.wrt_q.data(),
                                        data.wrt_reach.data());
}

template <class S>
void SteppingSystem::bend(const Data<S>& data, int part, const S& h, int rows, int first, S* by_q,
                          S* by_v, S* by_a) const {
  constexpr int kMost = 6;
  const int n = configurations_.curved()[part].n;
  const S* wrt_q = data.wrt_q.data() + StateManifold::kBlockSize * part;
  const S* wrt_reach = data.wrt_reach.data() + StateManifold::kBlockSize * part;
  for (int r = 0; r < rows; ++r) {
    const auto entry = [&](int i) { return (first + i) * rows + r; };
    S there[kMost];
    for (int i = 0; i < n; ++i) there[i] = by_q[entry(i)];
    for (int j = 0; j < n; ++j) {
      S turned(0.0), excess = -there[j];
      for (int i = 0; i < n; ++i) {
        turned += there[i] * wrt_q[i * n + j];
        excess += there[i] * wrt_reach[i * n + j];
      }
      by_q[entry(j)] = turned;
      by_v[entry(j)] += h * excess;
      by_a[entry(j)] += h * h * excess;
    }
  }
}

template <class S>
void SteppingSystem::backward_euler(const S* w, const S& h, bool slopes, Data<S>& data) const {
  const int n = nv();
  const RobotModel& model = robot_->robot();
  RobotData<S>& end = data.end.robot;
  const S* a = w + layout_.acceleration;
  mass_matrix(model, end);
  bias_forces(model, data.v.data(), end);
  robot_->applied_forces(data.v.data(), w, data.end);
  for (int i = 0; i < n; ++i) {
    data.motion[i] = end.bias[i] - data.end.force[i];
    for (int j = 0; j < n; ++j) data.motion[i] += symmetric(end.M, i, j, n) * a[j];
  }
  if (!slopes) return;
  std::copy_n(a, n, end.acceleration.begin());
  inverse_dynamics_derivatives(model, data.v.data(), end);
  robot_->add_passive_slopes(data.v.data(), end.tau_v.data());
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int e = j * n + i;
      data.motion_q[e] = end.tau_q[e];
      data.motion_v[e] = h * end.tau_q[e] + end.tau_v[e];
      data.motion_a[e] = h * data.motion_v[e] + symmetric(end.M, i, j, n);
    }
}

template <class S>
void SteppingSystem::variational_midpoint(const S* x, const S* w, const S& h, bool slopes,
                                          Data<S>& data) const {
  for (AlignedVector<S>* part : {&data.motion, &data.motion_q, &data.motion_v})
    std::fill(part->begin(), part->end(), S(0.0));
  for (const double sign : {-1.0, 1.0}) add_half_step(sign, x, w, h, slopes, data);
}

template <class S>
void SteppingSystem::add_half_step(double sign, const S* x, const S* w, const S& h, bool slopes,
                                   Data<S>& data) const {
  const int n = nv();
  HalfStep<S>& half = *data.half;
  const S* v = sign < 0 ? x + nq() : data.v.data();
  const S shift = S(0.5 * sign) * h, weight = S(sign) / h;
  for (int i = 0; i < n; ++i) half.position[i] = x[i] + shift * v[i];
  update_half_step(robot_->robot(), free_, v, slopes, half);
  robot_->applied_forces(v, w, data.end);
  for (int i = 0; i < n; ++i)
    data.motion[i] += weight * half.momentum[i] + S(0.5) * (half.load[i] - data.end.force[i]);
  if (slopes) add_half_step_slopes(sign, v, h, data);
}

template <class S>
void SteppingSystem::add_half_step_slopes(double sign, const S* v, const S& h,
                                          Data<S>& data) const {
  const int n = nv();
  const HalfStep<S>& half = *data.half;
  const S shift = S(0.5 * sign) * h, weight = S(sign) / h;
  AlignedVector<S>& passive = data.end.robot.tau_v;
  std::fill(passive.begin(), passive.end(), S(0.0));
  robot_->add_passive_slopes(v, passive.data());
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int e = j * n + i;
      const S by_q = weight * half.momentum_q[e] + S(0.5) * half.load_q[e];
      const S by_v = shift * by_q + weight * symmetric(half.mass(), i, j, n) +
                     S(0.5) * (half.load_v(i, j) + passive[e]);
      data.motion_q[e] += by_q;
      data.motion_v[e] += by_v;
      if (sign > 0) data.motion_a[e] = h * by_v;
    }
}

#define CONDDP_INSTANTIATE(S)                                                                  \
  template struct HalfStep<S>;                                                                 \
  template void update_half_step(const RobotModel&, const RobotModel&, const S*, bool,         \
                                 HalfStep<S>&);                                                \
  template struct SteppingSystem::Data<S>;                                                     \
  template void SteppingSystem::evaluate_as(const S*, const S*, Data<S>&) const;               \
  template void SteppingSystem::differentiate_as(const S*, const S*, Data<S>&) const;          \
  template void SteppingSystem::update_kinematics_as(const S*, Data<S>&) const;                \
  template void SteppingSystem::take_step(const S*, const S*, const S&, bool, Data<S>&) const; \
  template void SteppingSystem::bend(const Data<S>&, int, const S&, int, int, S*, S*, S*) const;
CONDDP_FOR_EACH_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
