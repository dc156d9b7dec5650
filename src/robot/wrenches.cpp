#include "robot/wrenches.hpp"

namespace conddp {
namespace {

/// An external wrench in the root frame: force, torque about the origin of its frame, and that
/// origin.
template <class S>
struct RootWrench {
  Vector3<S> force, torque, point;

  Force<S> at_origin() const { return {force, torque + cross(point, force)}; }
};

template <class S>
RootWrench<S> in_root_frame(const RobotModel& model, const RobotData<S>& data,
                            const ExternalWrench& w) {
  const Frame& frame = model.frames[w.frame];
  const Matrix3<S> r = data.root_pose(model, frame.joint).R;
  const SE3<S>& m = data.placement[frame.joint];
  return {transpose_times(r, w.wrench.linear), transpose_times(r, w.wrench.angular),
          m.p + m.R * frame.placement.p};
}

}  // namespace

template <class S>
void subtract_external_wrenches(const RobotModel& model, RobotData<S>& data) {
  for (const ExternalWrench& w : model.wrenches) {
    const int joint = model.frames[w.frame].joint;
    if (joint < 0) continue;
    data.force[joint] = data.force[joint] - in_root_frame(model, data, w).at_origin();
  }
}

namespace {

/// As a floating joint j rotates, the axes of the joints on the path to the wrench rotate with it.
template <class S>
void subtract_turns_of_base(const RobotModel& model, int j, int last, const RootWrench<S>& f,
                            RobotData<S>& data) {
  for (int k = 0; k < 3; ++k) {
    Vector3<S> e = Vector3<S>::zero();
    e[k] = S(1.0);
    const Vector3<S> df = cross(f.force, e);
    const Force<S> change{df, cross(f.torque, e) + cross(f.point, df)};
    for (int i = last; i >= 0; i = model.joints[i].parent) {
      S* column = &data.tau_q[(model.joints[j].v + 3 + k) * model.nv + model.joints[i].v];
      if (i == j)
        for (int row = 0; row < 6; ++row) column[row] -= change[row];
      else
        column[0] -= dot(data.axis[i], change);
    }
  }
}

/// A one-DoF joint j moves the point of attack and rotates the axes of the joints between it and
/// the wrench.
template <class S>
void subtract_moves_of_joint(const RobotModel& model, int j, int last, const RootWrench<S>& f,
                             const Force<S>& at_origin, RobotData<S>& data) {
  const Motion<S>& s = data.axis[j];
  const Vector3<S> shift = s.linear + cross(s.angular, f.point);
  const Vector3<S> torque_change = cross(shift, f.force);
  for (int i = last; i >= 0; i = model.joints[i].parent) {
    S* entry = &data.tau_q[model.joints[j].v * model.nv + model.joints[i].v];
    if (model.joints[i].type == JointType::floating) {
      for (int row = 0; row < 3; ++row) entry[3 + row] -= torque_change[row];
      continue;
    }
    S change = dot(data.axis[i].angular, torque_change);
    if (i > j) change += dot(cross(s, data.axis[i]), at_origin);
    entry[0] -= change;
  }
}

}  // namespace

template <class S>
void subtract_external_wrench_derivatives(const RobotModel& model, RobotData<S>& data) {
  for (const ExternalWrench& w : model.wrenches) {
    const int last = model.frames[w.frame].joint;
    if (last < 0) continue;
    const RootWrench<S> f = in_root_frame(model, data, w);
    const Force<S> at_origin = f.at_origin();
    for (int j = last; j >= 0; j = model.joints[j].parent) {
      if (model.joints[j].type == JointType::floating)
        subtract_turns_of_base(model, j, last, f, data);
      else
        subtract_moves_of_joint(model, j, last, f, at_origin, data);
    }
  }
}

#define CONDDP_INSTANTIATE(S)                                                 \
  template void subtract_external_wrenches(const RobotModel&, RobotData<S>&); \
  template void subtract_external_wrench_derivatives(const RobotModel&, RobotData<S>&);
CONDDP_FOR_EACH_KERNEL_SCALAR(CONDDP_INSTANTIATE)
CONDDP_INSTANTIATE(Dual<Dual<Lane>>)  // for Hessians of functions that take derivatives internally
#undef CONDDP_INSTANTIATE

}  // namespace conddp
