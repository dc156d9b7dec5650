#pragma once

#include "robot/inverse_dynamics_gradient.hpp"
#include "systems/multibody.hpp"
#include "systems/second_derivatives.hpp"

namespace conddp {

/// Second derivatives of forward dynamics with contacts, for robots without mimic joints and
/// external wrenches: with M a + b − Jᵀλ − B u = 0 and J a + c + ε λ = 0, weights (μ, ν) of (a, λ)
/// have the adjoint M w₁ + Jᵀ w₂ = μ, −J w₁ + ε w₂ = ν, which the factors of the forward problem
/// give. After Nganga, Wensing (IEEE RA-L 2021), with contacts.
class MultibodySecondDerivatives : public SecondDerivatives {
 public:
  MultibodySecondDerivatives(const MultibodySystem& system, MultibodySystem::Data<Lane>& at,
                             MultibodySystem::Data<Dual<Lane>>& moving);

  int forces() const override { return m_; }
  void start(const Dual<Lane>* x) override;
  void move_force(int row) override;
  void weigh(const Lane* of_f, const Lane* of_forces) override;
  void move(const Dual<Lane>* x, int d, Lane* gradients) override;
  void finish(Lane* gradients) override;

 private:
  using D = Dual<Lane>;

  /// Everything that depends on the configuration.
  void update_configuration(const D* x);
  /// The gradient of wᵀr at the moving point with accelerations and forces that stay, into
  /// gradient_; r of the contacts is what does not vanish.
  void differentiate_balance(const D* x);
  /// Gives the forces of `moving` these derivatives, one for each row of the contacts.
  template <class Slope>
  void set_forces(const Slope& slope);

  const MultibodySystem& system_;
  MultibodySystem::Data<Lane>& at_;
  MultibodySystem::Data<D>& moving_;
  int n_, m_, nz_;
  /// Coordinates of the configuration on which inverse dynamics and contacts do not depend: the
  /// position of a floating base.
  std::vector<bool> free_;
  bool configuration_moves_ = false, velocity_moves_ = false;
  AlignedVector<Lane> weight_;        ///< w₁, then w₂
  AlignedVector<D> velocity_weight_;  ///< w₁
  InverseDynamicsGradient<D> gradient_;
  AlignedVector<Lane> coupling_;  ///< (n + m) x n by columns: derivative of ∂(wᵀr)/∂(a, λ) by q
};

}  // namespace conddp
