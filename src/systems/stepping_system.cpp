#include "systems/stepping_system.hpp"

#include <algorithm>
#include <stdexcept>

#include "robot/kinematics.hpp"

namespace conddp {

SteppingSystem::SteppingSystem(std::shared_ptr<const MultibodySystem> robot,
                               ImplicitContacts contacts)
    : SystemBase(SystemKind::second_order, robot->manifold(), 0),
      robot_(std::move(robot)),
      contacts_(std::move(contacts)),
      layout_(robot_->robot(), robot_->control_columns(), contacts_) {
  for (const Joint& joint : robot_->robot().joints)
    if (joint.type == JointType::floating)
      throw std::invalid_argument("the joint '" + joint.name +
                                  "' floats, which contacts that are found do not allow");
  if (contacts_.scheme != SteppingScheme::backward_euler)
    throw std::invalid_argument("steps are those of backward Euler alone");
  if (contacts_.friction != FrictionModel::polyhedron)
    throw std::invalid_argument("friction is bounded by polyhedra alone");
  if (!robot_->mimic_map().identity())
    throw std::invalid_argument(
        "a joint mimics another one, which contacts that are found do not "
        "allow");
  for (const ContactCandidate& candidate : contacts_.candidates)
    geometry_.emplace_back(robot_->robot(), candidate, contacts_.plane);
  nu_ = layout_.size();
  state_columns_ = robot_->state_columns();
  control_columns_ = layout_.columns;
  control_lower_.assign(nu_, -kUnlimited);
  control_upper_.assign(nu_, kUnlimited);
  std::copy(robot_->control_lower().begin(), robot_->control_lower().end(), control_lower_.begin());
  std::copy(robot_->control_upper().begin(), robot_->control_upper().end(), control_upper_.begin());
}

template <class S>
SteppingSystem::Data<S>::Data(const SteppingSystem& system)
    : MultibodySystem::Data<S>(system.multibody()),
      end(system.multibody()),
      q(system.nq(), S(0.0)),
      v(system.nv(), S(0.0)) {
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
    data.q[i] = x[i] + h * data.v[i];
  }
  const RobotModel& model = robot_->robot();
  RobotData<S>& end = data.end.robot;
  update_placements(model, data.q.data(), end);
  update_velocities(model, data.v.data(), end);
  mass_matrix(model, end);
  bias_forces(model, data.v.data(), end);
  robot_->applied_forces(data.v.data(), w, data.end);
  for (std::size_t c = 0; c < geometry_.size(); ++c) {
    if (slopes)
      geometry_[c].differentiate(end, data.candidates[c]);
    else
      geometry_[c].evaluate(end, data.candidates[c]);
  }
  if (!slopes) return;
  std::copy_n(a, nv(), end.acceleration.begin());
  inverse_dynamics_derivatives(model, data.v.data(), end);
  robot_->add_passive_slopes(data.v.data(), end.tau_v.data());
}

#define CONDDP_INSTANTIATE(S)                                                         \
  template struct SteppingSystem::Data<S>;                                            \
  template void SteppingSystem::evaluate_as(const S*, const S*, Data<S>&) const;      \
  template void SteppingSystem::differentiate_as(const S*, const S*, Data<S>&) const; \
  template void SteppingSystem::update_kinematics_as(const S*, Data<S>&) const;       \
  template void SteppingSystem::take_step(const S*, const S*, const S&, bool, Data<S>&) const;
CONDDP_FOR_EACH_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

bool has_linear_step(const System& system) {
  return dynamic_cast<const SteppingSystem*>(&system) != nullptr;
}

}  // namespace conddp
