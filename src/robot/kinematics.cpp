#include "robot/kinematics.hpp"

#include "robot/loads.hpp"

namespace conddp {
namespace {

/// R Rz(θ).
template <class S>
Matrix3<S> turn_about_z(const Matrix3<S>& r, const S& s, const S& c) {
  return {{r.m[0] * c + r.m[1] * s, r.m[1] * c - r.m[0] * s, r.m[2], r.m[3] * c + r.m[4] * s,
           r.m[4] * c - r.m[3] * s, r.m[5], r.m[6] * c + r.m[7] * s, r.m[7] * c - r.m[6] * s,
           r.m[8]}};
}

}  // namespace

template <class S>
void update_placements(const RobotModel& model, const S* q, RobotData<S>& data) {
  for (int i = 0; i < model.joint_count(); ++i) {
    const Joint& joint = model.joints[i];
    if (joint.type == JointType::floating) {
      const S* x = q + joint.q;
      data.root[i] = {rotation_matrix(Quaternion<S>{x[3], x[4], x[5], x[6]}), {x[0], x[1], x[2]}};
      continue;
    }
    const bool on_root = joint.parent < 0 || model.joints[joint.parent].type == JointType::floating;
    SE3<S> m = on_root ? joint.placement.cast<S>() : data.placement[joint.parent] * joint.placement;
    if (joint.type == JointType::revolute) {
      S s, c;
      sincos(q[joint.q], s, c);
      m.R = turn_about_z(m.R, s, c);
      const Vector3<S> z = m.R.column(2);
      data.axis[i] = {cross(m.p, z), z};
    } else {
      const Vector3<S> z = m.R.column(2);
      m.p += q[joint.q] * z;
      data.axis[i] = {z, Vector3<S>::zero()};
    }
    data.placement[i] = m;
  }
}

template <class S>
void update_velocities(const RobotModel& model, const S* velocity, RobotData<S>& data) {
  for (int i = 0; i < model.joint_count(); ++i) {
    const Joint& joint = model.joints[i];
    const S* v = velocity + joint.v;
    if (joint.type == JointType::floating) {
      data.v[i] = {{v[0], v[1], v[2]}, {v[3], v[4], v[5]}};
    } else if (joint.parent < 0) {
      data.v[i] = v[0] * data.axis[i];
      data.psi_dot[i] = Motion<S>::zero();
    } else {
      data.psi_dot[i] = cross(data.v[joint.parent], data.axis[i]);
      data.v[i] = data.v[joint.parent] + v[0] * data.axis[i];
    }
  }
}

template <class S>
void update_accelerations(const RobotModel& model, const S* velocity, const S* acceleration,
                          RobotData<S>& data) {
  for (int i = 0; i < model.joint_count(); ++i) {
    const Joint& joint = model.joints[i];
    const S* a = acceleration == nullptr ? nullptr : acceleration + joint.v;
    if (joint.type == JointType::floating) {
      const Vector3<S> g = data.gravity(model, i);
      data.a[i] = a == nullptr ? Motion<S>{-g, Vector3<S>::zero()}
                               : Motion<S>{Vector3<S>{a[0], a[1], a[2]} - g, {a[3], a[4], a[5]}};
      continue;
    }
    if (joint.parent < 0)
      data.a[i] = {-model.gravity.cast<S>(), Vector3<S>::zero()};
    else
      data.a[i] = data.a[joint.parent] + velocity[joint.v] * data.psi_dot[i];
    if (a != nullptr) data.a[i] += a[0] * data.axis[i];
  }
}

template <class S>
void update_derivative_columns(const RobotModel& model, RobotData<S>& data) {
  for (int i = 0; i < model.joint_count(); ++i) {
    const Joint& joint = model.joints[i];
    if (joint.type == JointType::floating) continue;
    const Motion<S>& s = data.axis[i];
    const Motion<S> own = cross(data.v[i], s);
    if (joint.parent < 0) {
      data.psi_ddot[i] = cross(Motion<S>{-model.gravity.cast<S>(), Vector3<S>::zero()}, s);
      data.axis_rate[i] = own;
    } else {
      data.psi_ddot[i] =
          cross(data.a[joint.parent], s) + cross(data.v[joint.parent], data.psi_dot[i]);
      data.axis_rate[i] = data.psi_dot[i] + own;
    }
  }
}

template <class S>
void update_composite_inertias(const RobotModel& model, RobotData<S>& data) {
  for (int i = 0; i < model.joint_count(); ++i) {
    data.body[i] = inertia_in_root(model, data, i, model.joints[i].inertia);
    data.composite[i] = data.body[i];
  }
  add_loads(model, data);
  for (int i = model.joint_count() - 1; i >= 0; --i) {
    const Joint& joint = model.joints[i];
    if (joint.parent >= 0) data.composite[joint.parent] += data.composite[i];
    if (joint.type != JointType::floating) data.column[i] = data.composite[i] * data.axis[i];
  }
}

#define CONDDP_INSTANTIATE(S)                                                               \
  template void update_placements(const RobotModel&, const S*, RobotData<S>&);              \
  template void update_velocities(const RobotModel&, const S*, RobotData<S>&);              \
  template void update_accelerations(const RobotModel&, const S*, const S*, RobotData<S>&); \
  template void update_derivative_columns(const RobotModel&, RobotData<S>&);                \
  template void update_composite_inertias(const RobotModel&, RobotData<S>&);
CONDDP_FOR_EACH_KERNEL_SCALAR(CONDDP_INSTANTIATE)
CONDDP_INSTANTIATE(Dual<Dual<Lane>>)  // for Hessians of functions that take derivatives internally
#undef CONDDP_INSTANTIATE

}  // namespace conddp
