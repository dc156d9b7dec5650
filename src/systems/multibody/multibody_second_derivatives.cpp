#include <algorithm>

#include "robot/dynamics.hpp"
#include "systems/multibody/multibody.hpp"
#include "systems/system.hpp"

namespace conddp {

/// Second derivatives of forward dynamics with contacts, for robots without mimic joints and
/// external wrenches. The equations are M a + b − Jᵀλ − B u = 0 and J a + c + ε λ = 0. Weights (μ,
/// ν) of (a, λ) have the adjoint M w₁ + Jᵀ w₂ = μ, −J w₁ + ε w₂ = ν, solved with the factors of the
/// forward problem. After Nganga, Wensing (IEEE RA-L 2021), extended by contacts.
class MultibodySecondDerivatives : public SecondDerivatives {
 public:
  MultibodySecondDerivatives(const MultibodySystem& system, MultibodySystem::Data<Lane>& at,
                             MultibodySystem::Data<Dual<Lane>>& moving);

  int forces() const override { return m_; }
  void start(const Dual<Lane>* x, const Dual<Lane>* u) override;
  void move_force(int row) override;
  void weigh(const Lane* of_f, const Lane* of_forces) override;
  void move(const Dual<Lane>* x, int d, Lane* gradients) override;
  void finish(Lane* gradients) override;

 private:
  using D = Dual<Lane>;

  /// Updates all quantities that depend on the configuration.
  void update_configuration(const D* x);
  void update_state(const D* x, bool of_configuration, bool of_velocity);
  /// Writes the gradient of wᵀr at the moving point, for constant accelerations and forces, into
  /// gradient_. The rows r of the contacts are their nonzero residuals.
  void differentiate_balance(const D* x);
  void subtract_balance(const D* x, Lane* column);
  void couple_forces(Lane* coupling) const;
  /// Sets these derivatives of the forces of `moving`, one for each row of the contacts.
  template <class Slope>
  void set_forces(const Slope& slope);

  const MultibodySystem& system_;
  MultibodySystem::Data<Lane>& at_;
  MultibodySystem::Data<D>& moving_;
  int n_, m_, nz_;
  /// True for coordinates that neither inverse dynamics nor contacts depend on: the position of a
  /// floating base.
  std::vector<bool> free_;
  bool configuration_moves_ = false, velocity_moves_ = false;
  AlignedVector<Lane> weight_;        ///< w₁, then w₂
  AlignedVector<D> velocity_weight_;  ///< w₁
  InverseDynamicsGradient<D> gradient_;
  AlignedVector<Lane> coupling_;  ///< (n + m) x n by columns: derivative of ∂(wᵀr)/∂(a, λ) by q
};

MultibodySecondDerivatives::MultibodySecondDerivatives(const MultibodySystem& system,
                                                       MultibodySystem::Data<Lane>& at,
                                                       MultibodySystem::Data<Dual<Lane>>& moving)
    : system_(system),
      at_(at),
      moving_(moving),
      n_(system.nv()),
      m_(system.contacts().rows()),
      nz_(system.ndx() + system.nu()),
      free_(system.nv(), false),
      weight_(n_ + m_, Lane(0.0)),
      velocity_weight_(n_, D(0.0)),
      gradient_(system.robot()),
      coupling_((n_ + m_) * n_, Lane(0.0)) {
  for (const Contact& contact : system.contacts().contacts())
    if (contact.kp != 0 || contact.base) return;
  for (const Joint& joint : system.robot().joints)
    if (joint.type == JointType::floating) std::fill_n(free_.begin() + joint.v, 3, true);
}

void MultibodySecondDerivatives::update_configuration(const D* x) {
  const RobotModel& robot = system_.robot();
  update_placements(robot, x, moving_.robot);
  update_composite_inertias(robot, moving_.robot);
  system_.contacts().update(robot, moving_.robot, n_, moving_.contacts);
}

void MultibodySecondDerivatives::start(const Dual<Lane>* x, const Dual<Lane>* /*u*/) {
  update_configuration(x);
  update_velocities(system_.robot(), x + system_.nq(), moving_.robot);
  configuration_moves_ = velocity_moves_ = false;
  for (int i = 0; i < n_; ++i)
    moving_.robot.acceleration[i] = D(at_.robot.acceleration[i], Lane(0.0));
  const auto& slopes = at_.contacts.force_z;
  for (std::size_t i = 0; i < slopes.size(); ++i)
    moving_.contacts.force_z[i] = D(slopes[i], Lane(0.0));
}

template <class Slope>
void MultibodySecondDerivatives::set_forces(const Slope& slope) {
  if (m_ == 0) return;
  for (int r = 0; r < m_; ++r) moving_.contacts.force[r] = D(at_.contacts.force[r], slope(r));
  system_.contacts().distribute_forces(system_.robot(), moving_.contacts);
}

void MultibodySecondDerivatives::move_force(int row) {
  set_forces([row](int r) { return Lane(r == row ? 1.0 : 0.0); });
}

void MultibodySecondDerivatives::weigh(const Lane* of_f, const Lane* of_forces) {
  // The adjoint is a forward problem with another right-hand side; its forces are −w₂.
  Lane* w = weight_.data();
  std::copy_n(of_f, n_, w);
  const MassFactors<Lane> factors = system_.mass_factors(at_);
  system_.solver_.solve_first_half(factors, w);
  if (m_ > 0) {
    // The force vector is borrowed for the solve and restored afterwards.
    Lane* force = at_.contacts.force.data();
    for (int r = 0; r < m_; ++r) {
      w[n_ + r] = force[r];
      force[r] = -of_forces[r];
    }
    system_.solver_.hold_contacts(at_.contacts, w);
    for (int r = 0; r < m_; ++r) {
      const Lane result = force[r];
      force[r] = w[n_ + r];
      w[n_ + r] = -result;
    }
  }
  system_.solver_.solve_second_half(factors, w);
  for (int i = 0; i < n_; ++i) velocity_weight_[i] = D(w[i], Lane(0.0));
}

void MultibodySecondDerivatives::differentiate_balance(const D* x) {
  const RobotModel& robot = system_.robot();
  const ContactSet& set = system_.contacts();
  ContactSet::Data<D>& c = moving_.contacts;
  const D* w = velocity_weight_.data();
  const D* v = x + system_.nq();
  inverse_dynamics_gradient(robot, v, w, moving_.robot, set.empty() ? nullptr : &c.wrenches,
                            gradient_);
  for (int i = 0; i < set.count(); ++i) {
    const Contact& contact = set.contacts()[i];
    ContactData<D>& at = c.contacts[i];
    subtract_contact_gradient(robot, contact, at, w, gradient_.wrt_q);
    contact_acceleration_derivatives(robot, contact, moving_.robot, at);
    const Lane* of_rows = weight_.data() + n_ + set.offset(i);
    const std::vector<int>& columns = set.columns(i);
    const int rows = contact.rows();
    for (std::size_t k = 0; k < columns.size(); ++k)
      for (int r = 0; r < rows; ++r) {
        const D weight(of_rows[r], Lane(0.0));
        gradient_.wrt_q[columns[k]] += weight * at.wrt_q[k * rows + r];
        gradient_.wrt_v[columns[k]] += weight * at.wrt_v[k * rows + r];
        gradient_.wrt_a[columns[k]] += weight * at.jacobian[k * rows + r];
      }
  }
  system_.add_passive_slopes(v, w, gradient_.wrt_v.data());
}

void MultibodySecondDerivatives::move(const Dual<Lane>* x, int d, Lane* gradients) {
  const bool of_configuration = d < n_, of_velocity = !of_configuration && d < 2 * n_;
  update_state(x, of_configuration, of_velocity);
  if (of_velocity || (of_configuration && !free_[d])) subtract_balance(x, gradients + d * nz_);
  if (of_configuration) {
    Lane* coupling = &coupling_[d * (n_ + m_)];
    for (int i = 0; i < n_; ++i) coupling[i] = free_[d] ? Lane(0.0) : gradient_.wrt_a[i].d;
    couple_forces(coupling + n_);
  }
  set_forces([this, d](int r) { return at_.contacts.force_z[d * m_ + r]; });
}

/// Subtracts the balance at constant forces.
void MultibodySecondDerivatives::subtract_balance(const D* x, Lane* column) {
  set_forces([](int) { return Lane(0.0); });
  differentiate_balance(x);
  for (int i = 0; i < n_; ++i) {
    column[i] -= gradient_.wrt_q[i].d;
    column[n_ + i] -= gradient_.wrt_v[i].d;
  }
}

/// Updates the quantities that depend on parts of the state that move now or moved before.
void MultibodySecondDerivatives::update_state(const D* x, bool of_configuration, bool of_velocity) {
  if (of_configuration || configuration_moves_) update_configuration(x);
  if (of_configuration || of_velocity || configuration_moves_ || velocity_moves_)
    update_velocities(system_.robot(), x + system_.nq(), moving_.robot);
  configuration_moves_ = of_configuration;
  velocity_moves_ = of_velocity;
}

/// The derivative of ∂(wᵀr)/∂λ = −J w₁ + ε w₂ along the direction that moves.
void MultibodySecondDerivatives::couple_forces(Lane* coupling) const {
  std::fill_n(coupling, m_, Lane(0.0));
  const ContactSet& set = system_.contacts();
  for (int i = 0; i < set.count(); ++i) {
    const auto& jacobian = moving_.contacts.contacts[i].jacobian;
    const std::vector<int>& columns = set.columns(i);
    const int rows = set.contacts()[i].rows();
    for (std::size_t k = 0; k < columns.size(); ++k)
      for (int r = 0; r < rows; ++r)
        coupling[set.offset(i) + r] -= jacobian[k * rows + r].d * weight_[columns[k]];
  }
}

void MultibodySecondDerivatives::finish(Lane* gradients) {
  for (int j = 0; j < nz_; ++j) {
    const Lane* a = j < 2 * n_ ? at_.fx.data() + j * n_ : at_.fu.data() + (j - 2 * n_) * n_;
    const Lane* force = at_.contacts.force_z.data() + j * m_;
    for (int d = 0; d < n_; ++d) {
      if (free_[d]) continue;
      const Lane* coupling = &coupling_[d * (n_ + m_)];
      Lane sum(0.0);
      for (int i = 0; i < n_; ++i) sum += coupling[i] * a[i];
      for (int r = 0; r < m_; ++r) sum += coupling[n_ + r] * force[r];
      gradients[d * nz_ + j] -= sum;
      gradients[j * nz_ + d] -= sum;
    }
  }
}

std::unique_ptr<SecondDerivatives> MultibodySystem::second_derivatives(
    SystemData<Lane>& at, SystemData<Dual<Lane>>& moving) const {
  if (kind() == SystemKind::impulse || !mimics_.identity() || !robot_->wrenches.empty())
    return nullptr;
  return std::make_unique<MultibodySecondDerivatives>(*this, static_cast<Data<Lane>&>(at),
                                                      static_cast<Data<Dual<Lane>>&>(moving));
}

}  // namespace conddp
