// Contacts and impulses of MultibodySystem.
#include <algorithm>

#include "systems/multibody/multibody.hpp"

namespace conddp {

template <class S>
void MultibodySystem::prepare_contacts(Data<S>& data) const {
  contacts_.update(*robot_, data.robot, nv(), data.contacts);
  solver_.prepare_contacts(mass_factors(data), data.contacts, data.solver);
  contacts_.factorize(data.contacts);
}

template <class S>
void MultibodySystem::hold_contacts(Data<S>& data) const {
  // Body accelerations are those at zero generalized accelerations: the drift of the contacts.
  ContactSet::Data<S>& c = data.contacts;
  for (int i = 0; i < contacts_.count(); ++i)
    contact_acceleration(*robot_, contacts_.contacts()[i], data.robot, c.contacts[i],
                         &c.force[contacts_.offset(i)]);
  for (S& row : c.force) row = -row;
  solver_.hold_contacts(c, data.f.data());
  contacts_.distribute_forces(*robot_, c);
}

template <class S>
void MultibodySystem::load_contact_derivatives(Data<S>& data) const {
  ContactSet::Data<S>& c = data.contacts;
  std::fill(c.force_z.begin(), c.force_z.end(), S(0.0));
  contacts_.subtract_derivative(c, &ContactData<S>::wrt_q, 0, c.force_z.data());
  contacts_.subtract_derivative(c, &ContactData<S>::wrt_v, nv(), c.force_z.data());
}

template <class S>
void MultibodySystem::evaluate_impulse(const S* x, Data<S>& data) const {
  update_mass(full_coordinates(x, data), data);
  prepare_contacts(data);
  ContactSet::Data<S>& c = data.contacts;
  std::fill(c.force.begin(), c.force.end(), S(0.0));
  contacts_.add_product(c, -(1 + restitution_), x + nq(), c.force.data());
  std::fill(data.f.begin(), data.f.end(), S(0.0));
  solver_.hold_contacts(c, data.f.data());
  solver_.solve_second_half(mass_factors(data), data.f.data());
  for (int i = 0; i < nv(); ++i) data.f[i] += x[nq() + i];
  contacts_.distribute_forces(*robot_, c);
}

template <class S>
void MultibodySystem::differentiate_impulse(const S* x, Data<S>& data) const {
  evaluate_impulse(x, data);
  const int n = nv();
  const S* tau_q = differentiate_impulse_balance(x, data);
  differentiate_impulse_contacts(x, data);
  load_contact_derivatives(data);
  solver_.solve_columns<S>(mass_factors(data), tau_q, nullptr, data.contacts, data.fx.data(),
                           data.fu.data(), data.solver);
  for (int i = 0; i < n; ++i) data.fx[(n + i) * n + i] += S(1.0);
  // Costs use the velocities before the impulse.
  update_velocities(*robot_, full_coordinates(x, data).v, data.robot);
}

/// ∂(M δ − Jᵀλ)/∂q at δ = v⁺ − v. We use inverse dynamics at rest without gravity, with δ as
/// accelerations and λ as forces.
template <class S>
const S* MultibodySystem::differentiate_impulse_balance(const S* x, Data<S>& data) const {
  ContactSet::Data<S>& c = data.contacts;
  RobotData<S>& robot = data.robot;
  S* velocity = data.velocity.data();
  std::fill(data.velocity.begin(), data.velocity.end(), S(0.0));
  update_velocities(*weightless_, velocity, robot);
  for (int i = 0; i < nv(); ++i) data.force[i] = data.f[i] - x[nq() + i];
  expand_velocity(data.force.data(), robot.acceleration.data());
  inverse_dynamics_derivatives(*weightless_, velocity, robot, &c.wrenches);
  for (int i = 0; i < contacts_.count(); ++i)
    subtract_direction_derivative(*robot_, contacts_.contacts()[i], c.contacts[i], robot.tau_q);
  if (mimics_.identity()) return robot.tau_q.data();
  mimics_.reduce_matrix(robot.tau_q.data(), data.fx.data());
  return data.fx.data();
}

/// The contact condition is J w = 0 with w = v⁺ + restitution·v; v⁺ − v = M⁻¹ Jᵀλ.
template <class S>
void MultibodySystem::differentiate_impulse_contacts(const S* x, Data<S>& data) const {
  S* velocity = data.velocity.data();
  for (int i = 0; i < nv(); ++i) data.force[i] = data.f[i] + S(restitution_) * x[nq() + i];
  expand_velocity(data.force.data(), velocity);
  update_velocities(*robot_, velocity, data.robot);
  for (int i = 0; i < contacts_.count(); ++i) {
    ContactData<S>& contact = data.contacts.contacts[i];
    contact_velocity_derivative(*robot_, contacts_.contacts()[i], data.robot, contact);
    for (std::size_t k = 0; k < contact.wrt_v.size(); ++k)
      contact.wrt_v[k] = S(1 + restitution_) * contact.jacobian[k];
  }
}

#define CONDDP_INSTANTIATE(S)                                                \
  template void MultibodySystem::prepare_contacts(Data<S>&) const;           \
  template void MultibodySystem::hold_contacts(Data<S>&) const;              \
  template void MultibodySystem::load_contact_derivatives(Data<S>&) const;   \
  template void MultibodySystem::evaluate_impulse(const S*, Data<S>&) const; \
  template void MultibodySystem::differentiate_impulse(const S*, Data<S>&) const;
CONDDP_FOR_EACH_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
