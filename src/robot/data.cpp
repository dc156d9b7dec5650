#include "robot/data.hpp"

namespace conddp {

template <class S>
RobotData<S>::RobotData(const RobotModel& model)
    : root(model.joint_count(), SE3<S>::identity()),
      placement(model.joint_count(), SE3<S>::identity()),
      axis(model.joint_count(), Motion<S>::zero()),
      v(model.joint_count(), Motion<S>::zero()),
      a(model.joint_count(), Motion<S>::zero()),
      psi_dot(model.joint_count(), Motion<S>::zero()),
      psi_ddot(model.joint_count(), Motion<S>::zero()),
      axis_rate(model.joint_count(), Motion<S>::zero()),
      body(model.joint_count(), Inertia<S>::zero()),
      composite(model.joint_count(), Inertia<S>::zero()),
      momentum(model.joint_count(), Force<S>::zero()),
      inertia_rate(model.joint_count(), Symmetric3<S>::zero()),
      force(model.joint_count(), Force<S>::zero()),
      column(model.joint_count(), Force<S>::zero()),
      M(model.nv * model.nv, S(0.0)),
      L(model.nv * model.nv, S(0.0)),
      D_inverse(model.nv, S(0.0)),
      bias(model.nv, S(0.0)),
      acceleration(model.nv, S(0.0)),
      tau(model.nv, S(0.0)),
      tau_q(model.nv * model.nv, S(0.0)),
      tau_v(model.nv * model.nv, S(0.0)) {}

#define CONDDP_INSTANTIATE(S) template struct RobotData<S>;
CONDDP_FOR_EACH_KERNEL_SCALAR(CONDDP_INSTANTIATE)
CONDDP_INSTANTIATE(Dual<Dual<Lane>>)  // for Hessians of functions that take derivatives internally
#undef CONDDP_INSTANTIATE

}  // namespace conddp
