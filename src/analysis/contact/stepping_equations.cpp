#include "analysis/contact/stepping_equations.hpp"

#include <algorithm>
#include <cmath>

namespace conddp {

StepForces::StepForces(const ImplicitContacts& contacts)
    : contact(Eigen::Matrix3Xd::Zero(3, contacts.candidates.size())),
      stop_lower(Eigen::VectorXd::Zero(contacts.stops.size())),
      stop_upper(Eigen::VectorXd::Zero(contacts.stops.size())),
      friction(Eigen::VectorXd::Zero(contacts.frictions.size())) {}

bool StepForces::finite() const {
  return contact.allFinite() && stop_lower.allFinite() && stop_upper.allFinite() &&
         friction.allFinite();
}

template <class S>
const std::vector<S>& SteppingEquations<S>::free_impulse(const StepStart& start, const S* v) {
  if (plant_.contacts.scheme == SteppingScheme::backward_euler)
    backward_euler(start, v);
  else
    variational_midpoint(start, v);
  for (int i = 0; i < plant_.nv(); ++i) impulse_[i] = impulse_[i] - S(start.h * start.applied[i]);
  return impulse_;
}

template <class S>
void SteppingEquations<S>::reach_end(const StepStart& start, const S* v) {
  for (int i = 0; i < plant_.nv(); ++i) reach_[i] = S(start.h) * v[i];
  move_configuration(*plant_.robot, start.q.data(), reach_.data(), q_.data());
}

/// h (M(q⁺)(v⁺ − v)/h + c(q⁺, v⁺)).
template <class S>
void SteppingEquations<S>::backward_euler(const StepStart& start, const S* v) {
  const int n = plant_.nv();
  std::vector<S> a(n);
  reach_end(start, v);
  for (int i = 0; i < n; ++i) a[i] = (v[i] - S(start.v[i])) * S(1 / start.h);
  const std::vector<S>& load = mechanics_.load(q_.data(), v, a.data());
  for (int i = 0; i < n; ++i) impulse_[i] = S(start.h) * load[i];
}

/// M(q̄⁺) v⁺ − M(q̄⁻) v⁻ + h/2 (C(q̄⁺, v⁺) + C(q̄⁻, v⁻)) with C = g − ∂T/∂q + resistance: the discrete
/// Euler-Lagrange equations of the midpoint rule (Marsden and West 2001).
template <class S>
void SteppingEquations<S>::variational_midpoint(const StepStart& start, const S* v) {
  const int n = plant_.nv();
  const std::vector<S> zero(n, S(0.0));
  std::vector<S> before(n);
  for (int i = 0; i < n; ++i) {
    before[i] = S(start.v[i]);
    impulse_[i] = S(0.0);
  }
  const auto half = [&](const S* velocity, double sign) {
    for (int i = 0; i < n; ++i) q_[i] = S(start.q[i]) + S(0.5 * sign * start.h) * velocity[i];
    const auto add = [&](double weight, const std::vector<S>& part) {
      for (int i = 0; i < n; ++i) impulse_[i] = impulse_[i] + S(weight) * part[i];
    };
    add(0.5 * start.h - sign, mechanics_.load(q_.data(), zero.data(), zero.data()));
    add(sign, mechanics_.load(q_.data(), zero.data(), velocity));
    add(-0.5 * start.h, mechanics_.kinetic_slope(q_.data(), velocity));
    for (int i = 0; i < n; ++i)
      impulse_[i] = impulse_[i] + S(0.5 * start.h) * mechanics_.resistance(i, velocity[i]);
  };
  half(v, 1);
  half(before.data(), -1);
}

template <class S>
const std::vector<ContactInstant<S>>& SteppingEquations<S>::end(const StepStart& start,
                                                                const S* v) {
  reach_end(start, v);
  instants_ = &mechanics_.look(q_.data());
  return *instants_;
}

template <class S>
void SteppingEquations<S>::add_forces(double h, const StepForces& forces,
                                      std::vector<S>& impulse) const {
  const int n = plant_.nv();
  for (std::size_t c = 0; c < instants_->size(); ++c)
    for (int r = 0; r < 3; ++r)
      for (int i = 0; i < n; ++i)
        impulse[i] = impulse[i] + S(h * forces.contact(r, c)) * (*instants_)[c].rows[r * n + i];
  const auto at = [&](int joint) { return plant_.robot->joints[joint].v; };
  for (std::size_t s = 0; s < plant_.contacts.stops.size(); ++s) {
    const int i = at(plant_.contacts.stops[s].joint);
    impulse[i] = impulse[i] + S(h * (forces.stop_lower[s] - forces.stop_upper[s]));
  }
  for (std::size_t f = 0; f < plant_.contacts.frictions.size(); ++f) {
    const int i = at(plant_.contacts.frictions[f].joint);
    impulse[i] = impulse[i] + S(h * forces.friction[f]);
  }
}

template class SteppingEquations<double>;
template class SteppingEquations<Dual<double>>;

Eigen::VectorXd stepping_residual(const ContactPlant& plant, const StepStart& start,
                                  const Eigen::VectorXd& v, const StepForces& forces) {
  SteppingEquations<double> equations(plant);
  std::vector<double> pushed(plant.nv(), 0.0);
  equations.end(start, v.data());
  equations.add_forces(start.h, forces, pushed);
  const std::vector<double>& needed = equations.free_impulse(start, v.data());
  Eigen::VectorXd residual(plant.nv());
  for (int i = 0; i < plant.nv(); ++i) residual[i] = needed[i] - pushed[i];
  return residual;
}

double impulse_scale(const ContactPlant& plant, double h) {
  const double g = std::sqrt(squared_norm(plant.robot->gravity));
  return h * std::max(plant.robot->total_mass(), 1e-9) * (g > 0 ? g : 9.81);
}

}  // namespace conddp
