// Applied and passive forces of MultibodySystem.
#include <algorithm>

#include "systems/multibody/multibody.hpp"

namespace conddp {
namespace {

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

#define CONDDP_INSTANTIATE(S)                                                        \
  template void MultibodySystem::applied_forces(const S*, const S*, Data<S>&) const; \
  template void MultibodySystem::add_passive_slopes(const S*, S*) const;             \
  template void MultibodySystem::add_passive_slopes(const S*, const S*, S*) const;
CONDDP_FOR_EACH_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
