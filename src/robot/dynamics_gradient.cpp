
#include "robot/dynamics.hpp"
#include "robot/loads.hpp"

namespace conddp {

template <class S>
InverseDynamicsGradient<S>::InverseDynamicsGradient(const RobotModel& model)
    : virtual_velocity(model.joint_count(), Motion<S>::zero()),
      virtual_momentum(model.joint_count(), Force<S>::zero()),
      lever(model.joint_count(), Vector3<S>::zero()),
      wrt_q(model.nv, S(0.0)),
      wrt_v(wrt_q),
      wrt_a(wrt_q) {}

namespace {

/// Sets body velocities for the generalized velocities w, and clears the sums over subtrees.
template <class S>
void set_virtual_velocities(const RobotModel& model, const S* w, const RobotData<S>& data,
                            InverseDynamicsGradient<S>& out) {
  for (int i = 0; i < model.joint_count(); ++i) {
    const Joint& joint = model.joints[i];
    const S* x = w + joint.v;
    if (joint.type == JointType::floating)
      out.virtual_velocity[i] = {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}};
    else if (joint.parent < 0)
      out.virtual_velocity[i] = x[0] * data.axis[i];
    else
      out.virtual_velocity[i] = out.virtual_velocity[joint.parent] + x[0] * data.axis[i];
    out.virtual_momentum[i] = Force<S>::zero();
    out.lever[i] = Vector3<S>::zero();
  }
}

}  // namespace

template <class S>
void inverse_dynamics_gradient(const RobotModel& model, const S* v, const S* w, RobotData<S>& data,
                               const AlignedVector<Force<S>>* applied,
                               InverseDynamicsGradient<S>& out) {
  start_inverse_dynamics_derivatives(model, v, data, applied);
  set_virtual_velocities(model, w, data, out);
  for (int i = model.joint_count() - 1; i >= 0; --i) {
    const Joint& joint = model.joints[i];
    const Force<S>& h = data.momentum[i];
    const Symmetric3<S>& rate = data.inertia_rate[i];
    const Inertia<S>& y = data.composite[i];
    // The rows of i, multiplied by the motion m that w gives to this joint.
    const auto lever_of = [&](const Motion<S>& m) {
      return S(2.0) * cross(h.linear, m.linear) + rate * m.angular + cross(h.angular, m.angular);
    };
    const auto put = [&](AlignedVector<S>& to, const Force<S>& g) {
      for (int k = 0; k < 6; ++k) to[joint.v + k] = g[k];
    };
    if (joint.type == JointType::floating) {
      const Motion<S>& own = out.virtual_velocity[i];
      const Force<S> p = out.virtual_momentum[i] + y * own;
      const Vector3<S> z = out.lever[i] + lever_of(own);
      const Motion<S>& twist = data.v[i];
      put(out.wrt_q, {Vector3<S>::zero(), cross(data.gravity(model, i), p.linear)});
      put(out.wrt_v, {cross(p.linear, twist.angular),
                      z + cross(p.linear, twist.linear) + cross(p.angular, twist.angular)});
      put(out.wrt_a, p);
      continue;
    }
    const Motion<S>& s = data.axis[i];
    const S& own = w[joint.v];
    out.virtual_momentum[i] += Force<S>{own * data.column[i].linear, own * data.column[i].angular};
    out.lever[i] += own * lever_of(s);
    const Force<S>& p = out.virtual_momentum[i];
    const Vector3<S>& z = out.lever[i];
    S q = dot(z, data.psi_dot[i].angular) + dot(data.psi_ddot[i], p);
    S rate_of = dot(z, s.angular) + dot(data.axis_rate[i], p);
    S a = dot(s, p);
    if (joint.rotor_inertia != 0) a += own * S(joint.rotor_inertia);
    if (joint.parent >= 0) {
      // Effect of joint i's motion on its ancestors; the body velocity of the parent replaces their
      // axes.
      const Motion<S>& above = out.virtual_velocity[joint.parent];
      const auto twice_b = [&](const Vector3<S>& turn) {
        return Force<S>{S(2.0) * cross(turn, h.linear), rate * turn + cross(turn, h.angular)};
      };
      q += dot(above,
               twice_b(data.psi_dot[i].angular) + y * data.psi_ddot[i] + cross(s, data.force[i]));
      rate_of += dot(above, twice_b(s.angular) + y * data.axis_rate[i]);
      a += dot(above, data.column[i]);
      data.momentum[joint.parent] += h;
      data.inertia_rate[joint.parent] += rate;
      data.force[joint.parent] += data.force[i];
      out.virtual_momentum[joint.parent] += p;
      out.lever[joint.parent] += z;
    }
    out.wrt_q[joint.v] = q;
    out.wrt_v[joint.v] = rate_of;
    out.wrt_a[joint.v] = a;
  }
  add_load_gradients(model, data, out.virtual_velocity, out.wrt_q.data());
}

#define CONDDP_INSTANTIATE(S)                                                                   \
  template struct InverseDynamicsGradient<S>;                                                   \
  template void inverse_dynamics_gradient(const RobotModel&, const S*, const S*, RobotData<S>&, \
                                          const AlignedVector<Force<S>>*,                       \
                                          InverseDynamicsGradient<S>&);
CONDDP_FOR_EACH_KERNEL_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
