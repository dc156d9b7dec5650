// Contacts and impulses of MultibodySystem.
#include <algorithm>

#include "systems/dense_ldlt.hpp"
#include "systems/multibody.hpp"

namespace conddp {

template <class S>
void MultibodySystem::prepare_contacts(Data<S>& data) const {
  contacts_.update(*robot_, data.robot, nv(), data.contacts);
  solve_mass(data, data.contacts.response.data(), contacts_.rows());
  contacts_.factorize(nv(), data.contacts);
}

template <class S>
void MultibodySystem::hold_contacts(Data<S>& data) const {
  // Bodies still have their accelerations at zero generalised ones: the contacts' drift.
  ContactSet::Data<S>& c = data.contacts;
  for (int i = 0; i < contacts_.count(); ++i)
    contact_acceleration(*robot_, contacts_.contacts()[i], data.robot, c.contacts[i],
                         &c.force[contacts_.offset(i)]);
  for (S& row : c.force) row = -row;
  contacts_.add_product(c, -1, data.f.data(), c.force.data());
  contacts_.apply_forces(*robot_, nv(), data.f.data(), c);
  mimics_.expand_velocity(data.f.data(), data.robot.acceleration.data());
}

template <class S>
void MultibodySystem::differentiate_contacts(Data<S>& data) const {
  ContactSet::Data<S>& c = data.contacts;
  const int n = nv(), m = contacts_.rows();
  std::fill(c.force_z.begin(), c.force_z.end(), S(0.0));
  for (int i = 0; i < contacts_.count(); ++i)
    contact_acceleration_derivatives(*robot_, contacts_.contacts()[i], data.robot, c.contacts[i]);
  contacts_.subtract_derivative(c, &ContactData<S>::wrt_q, 0, c.force_z.data());
  contacts_.subtract_derivative(c, &ContactData<S>::wrt_v, n, c.force_z.data());
  contacts_.correct_columns(n, c, data.fx.data(), c.force_z.data(), 2 * n);
  contacts_.correct_columns(n, c, data.fu.data(), c.force_z.data() + 2 * n * m, nu_);
}

template <class S>
void MultibodySystem::evaluate_impulse(const S* x, Data<S>& data) const {
  const Coordinates<S> full = full_coordinates(x, data);
  update_placements(*robot_, full.q, data.robot);
  update_velocities(*robot_, full.v, data.robot);
  mass_matrix(*robot_, data.robot);
  if (mimics_.identity()) {
    factorize_mass_matrix(*robot_, data.robot);
  } else {
    mimics_.reduce_symmetric(data.robot.M.data(), data.mimic.M.data());
    factorize_ldlt(nv(), data.mimic.M.data());
  }
  prepare_contacts(data);
  ContactSet::Data<S>& c = data.contacts;
  std::copy(x + nq(), x + nx(), data.f.begin());
  std::fill(c.force.begin(), c.force.end(), S(0.0));
  contacts_.add_product(c, -(1 + restitution_), x + nq(), c.force.data());
  contacts_.apply_forces(*robot_, nv(), data.f.data(), c);
}

template <class S>
void MultibodySystem::differentiate_impulse(const S* x, Data<S>& data) const {
  evaluate_impulse(x, data);
  ContactSet::Data<S>& c = data.contacts;
  RobotData<S>& robot = data.robot;
  const int n = nv();
  // ∂(M δ − Jᵀλ)/∂q at δ = v⁺ − v: inverse dynamics at rest and without weight, δ and λ in the
  // places of accelerations and forces.
  S* velocity = data.velocity.data();
  std::fill(data.velocity.begin(), data.velocity.end(), S(0.0));
  update_velocities(*weightless_, velocity, robot);
  for (int i = 0; i < n; ++i) data.force[i] = data.f[i] - x[nq() + i];
  mimics_.expand_velocity(data.force.data(), robot.acceleration.data());
  inverse_dynamics_derivatives(*weightless_, velocity, robot, &c.wrenches);
  for (int i = 0; i < contacts_.count(); ++i)
    subtract_direction_derivative(*robot_, contacts_.contacts()[i], c.contacts[i], robot.tau_q);
  mimics_.reduce_matrix(robot.tau_q.data(), data.fx.data());
  for (int i = 0; i < n * n; ++i) data.fx[i] = -data.fx[i];
  solve_mass(data, data.fx.data(), n);
  std::fill(data.fx.begin() + n * n, data.fx.end(), S(0.0));
  for (int i = 0; i < n; ++i) data.fx[(n + i) * n + i] = S(1.0);

  // The contacts' condition is J w = 0 with w = v⁺ + restitution·v.
  for (int i = 0; i < n; ++i) data.force[i] = data.f[i] + S(restitution_) * x[nq() + i];
  mimics_.expand_velocity(data.force.data(), velocity);
  update_velocities(*robot_, velocity, robot);
  for (int i = 0; i < contacts_.count(); ++i) {
    ContactData<S>& contact = c.contacts[i];
    contact_velocity_derivative(*robot_, contacts_.contacts()[i], robot, contact);
    for (std::size_t k = 0; k < contact.wrt_v.size(); ++k)
      contact.wrt_v[k] = S(restitution_) * contact.jacobian[k];
  }
  std::fill(c.force_z.begin(), c.force_z.end(), S(0.0));
  contacts_.subtract_derivative(c, &ContactData<S>::wrt_q, 0, c.force_z.data());
  contacts_.subtract_derivative(c, &ContactData<S>::wrt_v, n, c.force_z.data());
  contacts_.correct_columns(n, c, data.fx.data(), c.force_z.data(), 2 * n);
  // Costs see the velocities before the impulse.
  update_velocities(*robot_, full_coordinates(x, data).v, robot);
}

#define CONDDP_INSTANTIATE(S)                                                \
  template void MultibodySystem::prepare_contacts(Data<S>&) const;           \
  template void MultibodySystem::hold_contacts(Data<S>&) const;              \
  template void MultibodySystem::differentiate_contacts(Data<S>&) const;     \
  template void MultibodySystem::evaluate_impulse(const S*, Data<S>&) const; \
  template void MultibodySystem::differentiate_impulse(const S*, Data<S>&) const;
CONDDP_FOR_EACH_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
