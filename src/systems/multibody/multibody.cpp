#include "systems/multibody/multibody.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace conddp {
namespace {

StateManifold state_space(const RobotModel& robot) {
  const MimicMap mimics(robot);
  StateManifold m;
  for (int i = 0; i < robot.joint_count(); ++i)
    if (mimics.position(i))
      m.append(robot.joints[i].type == JointType::floating ? StateManifold::Part::se3
                                                           : StateManifold::Part::flat,
               1);
  m.append(StateManifold::Part::flat, mimics.nv());
  return m;
}

void add_floating_names(const Joint& joint, std::vector<Column>& q, std::vector<Column>& v) {
  for (const char* axis : {"x", "y", "z"}) {
    q.push_back({joint.name + "/" + axis, "m"});
    v.push_back({joint.name + "/v" + axis, "m/s"});
  }
  for (const char* part : {"qx", "qy", "qz", "qw"}) q.push_back({joint.name + "/" + part, "1"});
  for (const char* axis : {"wx", "wy", "wz"}) v.push_back({joint.name + "/" + axis, "rad/s"});
}

/// A parameter that scales a load is a mass.
void add_parameter_names(const RobotModel& robot, int joint, std::vector<Column>& q,
                         std::vector<Column>& v) {
  const bool is_mass = std::any_of(robot.loads.begin(), robot.loads.end(),
                                   [&](const Load& load) { return load.parameter == joint; });
  const std::string& name = robot.joints[joint].name;
  q.push_back({name, is_mass ? "kg" : "1", true});
  v.push_back({name + "_rate", is_mass ? "kg/s" : "1/s", true});
}

std::vector<Column> state_names(const RobotModel& robot, const MimicMap& mimics) {
  std::vector<Column> q, v;
  for (int i = 0; i < robot.joint_count(); ++i) {
    if (!mimics.position(i)) continue;
    const Joint& joint = robot.joints[i];
    if (joint.type == JointType::floating) {
      add_floating_names(joint, q, v);
      continue;
    }
    if (joint.type == JointType::parameter) {
      add_parameter_names(robot, i, q, v);
      continue;
    }
    const bool turns = joint.type == JointType::revolute;
    q.push_back({"q/" + joint.name, turns ? "rad" : "m"});
    v.push_back({"v/" + joint.name, turns ? "rad/s" : "m/s"});
  }
  q.insert(q.end(), v.begin(), v.end());
  return q;
}

const Mimic* find_mimic(const RobotModel& model, int joint) {
  for (const Mimic& mimic : model.mimics)
    if (mimic.joint == joint) return &mimic;
  return nullptr;
}

/// True if a joint can be actuated independently.
bool has_motor(const RobotModel& model, int joint) {
  const JointType type = model.joints[joint].type;
  return type != JointType::floating && type != JointType::parameter &&
         find_mimic(model, joint) == nullptr;
}

/// Appends a control that acts as one joint's generalized force.
void add_joint(const RobotModel& model, int index, Actuation& actuation) {
  const Joint& joint = model.joints[index];
  if (joint.type == JointType::floating)
    throw std::invalid_argument("joint " + joint.name + " is a floating base: use thrusters");
  if (const Mimic* mimic = find_mimic(model, index))
    throw std::invalid_argument("joint " + joint.name + " mimics joint " +
                                model.joints[mimic->leader].name +
                                ": controls act on independent joints");
  actuation.B.resize(actuation.B.size() + model.nv, 0.0);
  actuation.B[actuation.nu * model.nv + joint.v] = 1;
  ++actuation.nu;
  actuation.columns.push_back({"u/" + joint.name, joint.type == JointType::revolute ? "Nm" : "N"});
  actuation.lower.push_back(-joint.max_effort);
  actuation.upper.push_back(joint.max_effort);
}

/// Appends a control that acts as a thruster's wrench on a floating base.
void add_thruster(const RobotModel& model, const Thruster& thruster, Actuation& actuation) {
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

}  // namespace

Actuation Actuation::full(const RobotModel& model) {
  Actuation actuation;
  for (int i = 0; i < model.joint_count(); ++i)
    if (has_motor(model, i)) add_joint(model, i, actuation);
  return actuation;
}

Actuation Actuation::joints(const RobotModel& model, const std::vector<std::string>& names) {
  return thrusters(model, {}, names);
}

Actuation Actuation::thrusters(const RobotModel& model, const std::vector<Thruster>& thrusters,
                               const std::vector<std::string>& joint_names) {
  Actuation actuation;
  for (const Thruster& thruster : thrusters) add_thruster(model, thruster, actuation);
  for (const std::string& name : joint_names) {
    const auto index = model.find_joint(name);
    if (!index) throw std::invalid_argument("no joint is called " + name);
    add_joint(model, *index, actuation);
  }
  return actuation;
}

MultibodySystem::MultibodySystem(std::shared_ptr<const RobotModel> robot,
                                 std::vector<Contact> contacts, double restitution)
    : SystemBase(SystemKind::impulse, state_space(*robot), 0),
      robot_(std::move(robot)),
      mimics_(*robot_),
      contacts_(*robot_, mimics_, std::move(contacts)),
      restitution_(restitution) {
  auto weightless = std::make_shared<RobotModel>(*robot_);
  weightless->gravity = Vector3<double>::zero();
  weightless->wrenches.clear();
  weightless_ = std::move(weightless);
  state_columns_ = state_names(*robot_, mimics_);
  solver_ = ColumnSolver(*robot_, !mimics_.identity(), nv(), contacts_, entries_, nu_);
}

MultibodySystem::MultibodySystem(std::shared_ptr<const RobotModel> robot, Actuation actuation,
                                 PassiveForces passive, std::vector<Contact> contacts)
    : SystemBase(SystemKind::second_order, state_space(*robot), actuation.nu),
      robot_(std::move(robot)),
      mimics_(*robot_),
      actuation_(std::move(actuation)),
      contacts_(*robot_, mimics_, std::move(contacts)),
      passive_(passive) {
  state_columns_ = state_names(*robot_, mimics_);
  control_columns_ = actuation_.columns;
  control_lower_ = actuation_.lower;
  control_upper_ = actuation_.upper;
  index_actuation();
  add_passive_joints();
  solver_ = ColumnSolver(*robot_, !mimics_.identity(), nv(), contacts_, entries_, nu_);
}

/// Transforms the control matrix to the system's rows, and lists its entries.
void MultibodySystem::index_actuation() {
  const int n = nv();
  std::vector<double> B(n * nu_);
  for (int c = 0; c < nu_; ++c) {
    mimics_.reduce_force(&actuation_.B[c * robot_->nv], &B[c * n]);
    for (int r = 0; r < n; ++r)
      if (const double value = B[c * n + r]; value != 0) entries_.push_back({r, c, value});
  }
  actuation_.B = std::move(B);
}

void MultibodySystem::add_passive_joints() {
  for (const Joint& joint : robot_->joints) {
    if (joint.type == JointType::floating) continue;
    // A mimic joint moves at k times the row's velocity, and its force acts on the row with the
    // same factor k.
    const double k = std::abs(mimics_.factor(joint.v));
    const double damping = passive_.damping ? k * k * joint.damping : 0;
    const double friction = passive_.friction ? k * joint.friction : 0;
    if (damping != 0 || friction > 0)
      passive_joints_.push_back(
          {mimics_.column(joint.v), damping, friction, passive_.friction_velocity / k});
  }
}

std::shared_ptr<MultibodySystem> MultibodySystem::with_contacts(
    std::vector<Contact> contacts) const {
  auto held = std::make_shared<MultibodySystem>(*this);
  held->contacts_ = ContactSet(*robot_, mimics_, std::move(contacts));
  held->solver_ = ColumnSolver(*robot_, !mimics_.identity(), nv(), held->contacts_, entries_, nu_);
  return held;
}

void MultibodySystem::soften_redundant_contacts(const double* x) {
  contacts_.soften(contact_rank(x).softness);
}

std::vector<int> MultibodySystem::actuated_rows() const {
  std::vector<int> rows;
  for (const auto& e : entries_) rows.push_back(e.row);
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  return rows;
}

std::optional<int> MultibodySystem::velocity_index(int joint) const {
  const auto row = velocity_row(joint);
  return row ? std::optional(nq() + *row) : std::nullopt;
}

std::vector<double> MultibodySystem::reduce_configuration(const std::vector<double>& full) const {
  std::vector<double> q(nq());
  for (int i = 0; i < robot_->joint_count(); ++i)
    if (const auto at = position_index(i))
      std::copy_n(&full[robot_->joints[i].q], robot_->joints[i].nq(), &q[*at]);
  return q;
}

std::vector<double> MultibodySystem::reduce_velocity(const std::vector<double>& full) const {
  std::vector<double> v(nv());
  for (int i = 0; i < robot_->joint_count(); ++i)
    if (const auto at = velocity_row(i))
      std::copy_n(&full[robot_->joints[i].v], robot_->joints[i].nv(), &v[*at]);
  return v;
}

std::vector<double> MultibodySystem::expand_configuration(const std::vector<double>& q) const {
  std::vector<double> full(robot_->nq);
  mimics_.expand_configuration(q.data(), full.data());
  return full;
}

std::vector<double> MultibodySystem::expand_velocity(const std::vector<double>& v) const {
  std::vector<double> full(robot_->nv);
  mimics_.expand_velocity(v.data(), full.data());
  return full;
}

std::vector<double> MultibodySystem::reduce_force(const std::vector<double>& full) const {
  std::vector<double> force(nv());
  mimics_.reduce_force(full.data(), force.data());
  return force;
}

MultibodySystem::JointLimits MultibodySystem::limits(int joint) const {
  const Joint& own = robot_->joints[joint];
  JointLimits result{own.lower, own.upper, own.max_velocity};
  for (const Mimic& mimic : robot_->mimics) {
    if (mimic.leader != joint || mimic.multiplier == 0) continue;
    const Joint& follower = robot_->joints[mimic.joint];
    const double a = (follower.lower - mimic.offset) / mimic.multiplier;
    const double b = (follower.upper - mimic.offset) / mimic.multiplier;
    result.lower = std::max(result.lower, std::min(a, b));
    result.upper = std::min(result.upper, std::max(a, b));
    result.max_velocity =
        std::min(result.max_velocity, follower.max_velocity / std::abs(mimic.multiplier));
  }
  return result;
}

template <class S>
MultibodySystem::Data<S>::Data(const MultibodySystem& system)
    : robot(system.robot()),
      force(system.nv(), S(0.0)),
      gravity(system.nv(), S(0.0)),
      gravity_q(system.nv() * system.nv(), S(0.0)),
      velocity(system.robot().nv, S(0.0)),
      columns(6 * system.robot().nv, S(0.0)),
      frame_columns(columns),
      contacts(system.contacts(), system.robot(), system.nv(), system.nu()),
      solver(system.solver_) {
  if (system.mimic_map().identity()) return;
  const RobotModel& model = system.robot();
  mimic.q.assign(model.nq, S(0.0));
  mimic.v.assign(model.nv, S(0.0));
  mimic.gravity.assign(model.nv, S(0.0));
  mimic.M.assign(system.nv() * system.nv(), S(0.0));
  mimic.gravity_q.assign(model.nv * model.nv, S(0.0));
  mimic.columns.assign(6 * model.nv, S(0.0));
}

template <class S>
MultibodySystem::Coordinates<S> MultibodySystem::full_coordinates(const S* x, Data<S>& data) const {
  if (mimics_.identity()) return {x, x + nq()};
  mimics_.expand_configuration(x, data.mimic.q.data());
  mimics_.expand_velocity(x + nq(), data.mimic.v.data());
  return {data.mimic.q.data(), data.mimic.v.data()};
}

template <class S>
MassFactors<S> MultibodySystem::mass_factors(const Data<S>& data) const {
  if (mimics_.identity()) return {data.robot.L.data(), data.robot.D_inverse.data(), 1};
  return {data.mimic.M.data(), data.mimic.M.data(), nv() + 1};
}

template <class S>
void MultibodySystem::expand_velocity(const S* v, S* full) const {
  if (mimics_.identity())
    std::copy(v, v + nv(), full);
  else
    mimics_.expand_velocity(v, full);
}

template <class S>
void MultibodySystem::update_mass(const Coordinates<S>& full, Data<S>& data) const {
  update_placements(*robot_, full.q, data.robot);
  update_velocities(*robot_, full.v, data.robot);
  mass_matrix(*robot_, data.robot);
  if (mimics_.identity()) return factorize_mass_matrix(*robot_, data.robot);
  mimics_.reduce_symmetric(data.robot.M.data(), data.mimic.M.data());
  factorize_ldlt(nv(), data.mimic.M.data());
}

template <class S>
void MultibodySystem::evaluate_as(const S* x, const S* u, Data<S>& data) const {
  if (kind() == SystemKind::impulse) return evaluate_impulse(x, data);
  applied_forces(x + nq(), u, data);
  const Coordinates<S> full = full_coordinates(x, data);
  update_mass(full, data);
  bias_forces(*robot_, full.v, data.robot);
  const S* bias = data.robot.bias.data();
  if (!mimics_.identity()) {
    mimics_.reduce_force(bias, data.f.data());
    bias = data.f.data();
  }
  for (int i = 0; i < nv(); ++i) data.f[i] = data.force[i] - bias[i];
  solver_.solve_first_half(mass_factors(data), data.f.data());
  if (!contacts_.empty()) {
    prepare_contacts(data);
    hold_contacts(data);
  }
  solver_.solve_second_half(mass_factors(data), data.f.data());
  expand_velocity(data.f.data(), data.robot.acceleration.data());
}

template <class S>
void MultibodySystem::differentiate_as(const S* x, const S* u, Data<S>& data) const {
  if (kind() == SystemKind::impulse) return differentiate_impulse(x, data);
  evaluate_as(x, u, data);
  const int n = nv();
  const S* v = x + nq();
  const bool identity = mimics_.identity();
  clear_other_branches(data);
  inverse_dynamics_derivatives(*robot_, identity ? v : data.mimic.v.data(), data.robot,
                               contacts_.empty() ? nullptr : &data.contacts.wrenches);
  for (int i = 0; i < contacts_.count(); ++i) {
    const Contact& contact = contacts_.contacts()[i];
    subtract_contact_derivative(*robot_, contact, data.contacts.contacts[i], data.robot.tau_q);
    contact_acceleration_derivatives(*robot_, contact, data.robot, data.contacts.contacts[i]);
  }
  load_contact_derivatives(data);
  S* tau_q = identity ? data.robot.tau_q.data() : data.fx.data();
  S* tau_v = identity ? data.robot.tau_v.data() : tau_q + n * n;
  if (!identity) {
    mimics_.reduce_matrix(data.robot.tau_q.data(), tau_q);
    mimics_.reduce_matrix(data.robot.tau_v.data(), tau_v);
  }
  add_passive_slopes(v, tau_v);
  solver_.solve_columns(mass_factors(data), tau_q, tau_v, data.contacts, data.fx.data(),
                        data.fu.data(), data.solver);
}

template <class S>
void MultibodySystem::update_kinematics_as(const S* x, Data<S>& data) const {
  const Coordinates<S> full = full_coordinates(x, data);
  update_placements(*robot_, full.q, data.robot);
  update_velocities(*robot_, full.v, data.robot);
  update_composite_inertias(*robot_, data.robot);
}

template <class S>
void MultibodySystem::gravity_torques(Data<S>& data, bool derivative) const {
  const bool identity = mimics_.identity();
  AlignedVector<S>& g = identity ? data.gravity : data.mimic.gravity;
  AlignedVector<S>& g_q = identity ? data.gravity_q : data.mimic.gravity_q;
  conddp::gravity_torques(*robot_, data.robot, g.data(), derivative ? g_q.data() : nullptr);
  if (identity) return;
  mimics_.reduce_force(g.data(), data.gravity.data());
  if (derivative) mimics_.reduce_matrix(g_q.data(), data.gravity_q.data());
}

#define CONDDP_INSTANTIATE(S)                                                                    \
  template struct MultibodySystem::Data<S>;                                                      \
  template MassFactors<S> MultibodySystem::mass_factors(const Data<S>&) const;                   \
  template void MultibodySystem::expand_velocity(const S*, S*) const;                            \
  template void MultibodySystem::update_mass(const Coordinates<S>&, Data<S>&) const;             \
  template MultibodySystem::Coordinates<S> MultibodySystem::full_coordinates(const S*, Data<S>&) \
      const;                                                                                     \
  template void MultibodySystem::evaluate_as(const S*, const S*, Data<S>&) const;                \
  template void MultibodySystem::differentiate_as(const S*, const S*, Data<S>&) const;           \
  template void MultibodySystem::update_kinematics_as(const S*, Data<S>&) const;                 \
  template void MultibodySystem::gravity_torques(Data<S>&, bool) const;
CONDDP_FOR_EACH_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
