#include "systems/contact/half_step.hpp"

#include <algorithm>

#include "robot/dynamics.hpp"
#include "systems/system.hpp"

namespace conddp {

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

#define CONDDP_INSTANTIATE(S)                                                          \
  template struct HalfStep<S>;                                                         \
  template void update_half_step(const RobotModel&, const RobotModel&, const S*, bool, \
                                 HalfStep<S>&);
CONDDP_FOR_EACH_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
