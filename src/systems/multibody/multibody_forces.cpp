// Forces on a MultibodySystem: applied, passive, of contacts, and impulses.
#include <algorithm>

#include "base/matrix_decompositions.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {
namespace {

/// A contact participates in a unit vector of forces if one of its components exceeds this.
constexpr double kTakesPart = 0.05;
/// Bounds on scaled eigenvalues. Below the first, forces are due to rounding; below the second,
/// they change too fast with the posture for solvers.
constexpr double kIdle = 1e-5, kSoft = 1e-2;

/// Rows whose forces have an effect: their diagonal entry of G exceeds ten times the compliance.
std::vector<int> moving_rows(const Eigen::MatrixXd& G, double compliance) {
  std::vector<int> moving;
  for (int i = 0; i < G.rows(); ++i)
    if (G(i, i) > 10 * compliance) moving.push_back(i);
  return moving;
}

/// The contacts that participate in forces without effect.
std::vector<std::string> contacts_in(const ContactSet& contacts, const Eigen::MatrixXd& forces) {
  std::vector<std::string> names;
  if (forces.cols() == 0) return names;
  for (int i = 0; i < contacts.count(); ++i) {
    const Contact& contact = contacts.contacts()[i];
    if (forces.middleRows(contacts.offset(i), contact.rows()).cwiseAbs().maxCoeff() > kTakesPart)
      names.push_back(contact.name);
  }
  return names;
}

/// 1/(1 + exp(2 v/scale)), so that tanh(v/scale) = 1 − 2·logistic. The argument is clamped in
/// saturation, which keeps exp finite.
template <class S>
S logistic(const S& v, double scale) {
  return S(1.0) / (S(1.0) + exp(max(S(-40.0), min(S(40.0), v * S(2 / scale)))));
}

}  // namespace

template <class S>
void MultibodySystem::applied_forces(const S* v, const S* u, Data<S>& data) const {
  std::fill(data.force.begin(), data.force.end(), S(0.0));
  for (const auto& e : entries_) data.force[e.row] += u[e.column] * S(e.value);
  for (const PassiveJoint& joint : passive_joints_) {
    S& force = data.force[joint.row];
    force -= v[joint.row] * S(joint.damping);
    if (joint.friction > 0)
      force -=
          S(joint.friction) * (S(1.0) - S(2.0) * logistic(v[joint.row], joint.friction_velocity));
  }
}

template <class S>
S MultibodySystem::slope(const PassiveJoint& joint, const S& v) {
  S sum(joint.damping);
  if (joint.friction > 0) {
    const S h = logistic(v, joint.friction_velocity);
    sum += S(4 * joint.friction / joint.friction_velocity) * (S(1.0) - h) * h;
  }
  return sum;
}

template <class S>
void MultibodySystem::add_passive_slopes(const S* v, S* tau_v) const {
  for (const PassiveJoint& joint : passive_joints_)
    tau_v[joint.row * (nv() + 1)] += slope(joint, v[joint.row]);
}

template <class S>
void MultibodySystem::add_passive_slopes(const S* v, const S* w, S* gradient) const {
  for (const PassiveJoint& joint : passive_joints_)
    gradient[joint.row] += w[joint.row] * slope(joint, v[joint.row]);
}

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
void MultibodySystem::clear_other_branches(Data<S>& data) const {
  const auto is_loop = [](const Contact& contact) { return contact.base.has_value(); };
  if (std::ranges::any_of(contacts_.contacts(), is_loop))
    std::fill(data.robot.tau_q.begin(), data.robot.tau_q.end(), S(0.0));
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
  clear_other_branches(data);
  inverse_dynamics_derivatives(*weightless_, velocity, robot, &c.wrenches);
  for (int i = 0; i < contacts_.count(); ++i)
    subtract_contact_derivative(*robot_, contacts_.contacts()[i], c.contacts[i], robot.tau_q);
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

#define CONDDP_INSTANTIATE(S)                                                        \
  template void MultibodySystem::applied_forces(const S*, const S*, Data<S>&) const; \
  template void MultibodySystem::add_passive_slopes(const S*, S*) const;             \
  template void MultibodySystem::add_passive_slopes(const S*, const S*, S*) const;   \
  template void MultibodySystem::prepare_contacts(Data<S>&) const;                   \
  template void MultibodySystem::hold_contacts(Data<S>&) const;                      \
  template void MultibodySystem::load_contact_derivatives(Data<S>&) const;           \
  template void MultibodySystem::clear_other_branches(Data<S>&) const;               \
  template void MultibodySystem::evaluate_impulse(const S*, Data<S>&) const;         \
  template void MultibodySystem::differentiate_impulse(const S*, Data<S>&) const;
CONDDP_FOR_EACH_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

ContactRank MultibodySystem::contact_rank(const double* x) const {
  ContactRank found;
  if (contacts_.empty()) return found;
  const ContactSet& contacts = contacts_;
  found.rows = found.rank = contacts.rows();
  const auto data = create_data(double{});
  const std::vector<double> u(nu(), 0.0);
  evaluate(x, u.data(), *data);
  const auto& held = static_cast<const Data<double>&>(*data).contacts;
  const Eigen::Map<const Eigen::MatrixXd> lower(held.G.data(), found.rows, found.rows);
  const Eigen::MatrixXd G = lower.selfadjointView<Eigen::Lower>();
  if (!G.allFinite()) return found;

  const std::vector<int> moving = moving_rows(G, contacts.compliance());
  found.rows = found.rank = static_cast<int>(moving.size());
  if (moving.empty()) return found;
  const Eigen::VectorXd size = G.diagonal()(moving).cwiseSqrt();
  const Eigen::MatrixXd scaled =
      size.cwiseInverse().asDiagonal() * G(moving, moving) * size.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(scaled);
  const Eigen::VectorXd& values = modes.eigenvalues();  // ascending
  const int idle = static_cast<int>((values.array() <= kIdle).count());
  const int soft = static_cast<int>((values.array() < kSoft).count());
  found.rank = found.rows - idle;
  if (soft == 0) return found;

  Eigen::MatrixXd directions = Eigen::MatrixXd::Zero(contacts.rows(), soft);
  directions(moving, Eigen::all) = size.asDiagonal() * modes.eigenvectors().leftCols(soft);
  const Eigen::VectorXd raise = (kSoft - values.head(soft).array()).matrix();
  found.softness = directions * raise.asDiagonal() * directions.transpose();
  Eigen::MatrixXd forces = Eigen::MatrixXd::Zero(contacts.rows(), idle);
  forces(moving, Eigen::all) = modes.eigenvectors().leftCols(idle);
  found.redundant = contacts_in(contacts, forces);
  return found;
}

}  // namespace conddp
