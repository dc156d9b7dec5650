#include "robot/frames.hpp"

#include <algorithm>

#include "robot/joint_axes.hpp"
#include "robot/loads.hpp"

namespace conddp {
namespace {

template <class S>
void store(const Motion<S>& m, S* column) {
  for (int i = 0; i < 6; ++i) column[i] = m[i];
}

/// Writes the columns of a floating base in the Jacobian of a frame with this placement, in its
/// axes. The motions are unit vectors, so only the lever needs products.
template <class S>
void store_base_columns(const SE3<S>& m, S* columns) {
  for (int k = 0; k < 3; ++k) {
    const int low = k == 0 ? 1 : 0, high = k == 2 ? 1 : 2;
    S *linear = columns + 6 * k, *angular = columns + 6 * (k + 3);
    for (int i = 0; i < 3; ++i) {
      const S lever = m.R(high, i) * m.p[low] - m.R(low, i) * m.p[high];
      linear[i] = angular[3 + i] = m.R(k, i);
      linear[3 + i] = S(0.0);
      angular[i] = k == 1 ? -lever : lever;
    }
  }
}

/// Rotation from the axes of a frame, placed in the root frame, to those of the world; the identity
/// for local axes.
template <class S>
Matrix3<S> world_rotation(const RobotModel& model, const RobotData<S>& data, int joint,
                          const SE3<S>& m, FrameAxes axes) {
  if (axes == FrameAxes::local) return Matrix3<S>::identity();
  return data.root_pose(model, joint).R * m.R;
}

/// Rotates both parts of a motion.
template <class S>
Motion<S> rotate(const Matrix3<S>& r, const Motion<S>& m) {
  return {r * m.linear, r * m.angular};
}

}  // namespace

std::vector<int> support(const RobotModel& model, int joint) {
  std::vector<int> columns;
  for (int j = joint; j >= 0; j = model.joints[j].parent)
    for (int k = model.joints[j].nv() - 1; k >= 0; --k) columns.push_back(model.joints[j].v + k);
  std::reverse(columns.begin(), columns.end());
  return columns;
}

int support_size(const RobotModel& model, int joint) {
  int n = 0;
  for (int j = joint; j >= 0; j = model.joints[j].parent) n += model.joints[j].nv();
  return n;
}

template <class S>
SE3<S> frame_placement(const RobotModel& model, const RobotData<S>& data, int frame) {
  return data.root_pose(model, model.frames[frame].joint) * placement_in_root(model, data, frame);
}

template <class S>
Motion<S> frame_velocity(const RobotModel& model, const RobotData<S>& data, int frame,
                         FrameAxes axes) {
  const int joint = model.frames[frame].joint;
  if (joint < 0) return Motion<S>::zero();
  const SE3<S> m = placement_in_root(model, data, frame);
  const Motion<S> local = act_inverse(m, data.v[joint]);
  return axes == FrameAxes::local ? local : rotate(data.root_pose(model, joint).R * m.R, local);
}

template <class S>
Motion<S> frame_acceleration(const RobotModel& model, const RobotData<S>& data, int frame,
                             FrameAxes axes) {
  const int joint = model.frames[frame].joint;
  if (joint < 0) return Motion<S>::zero();
  const SE3<S> m = placement_in_root(model, data, frame);
  Motion<S> a = data.a[joint];
  a.linear += data.gravity(model, joint);
  const Motion<S> local = act_inverse(m, a);
  return axes == FrameAxes::local ? local : rotate(data.root_pose(model, joint).R * m.R, local);
}

template <class S>
void frame_jacobian(const RobotModel& model, const RobotData<S>& data, int frame, FrameAxes axes,
                    S* jacobian) {
  const int joint = model.frames[frame].joint;
  const SE3<S> m = placement_in_root(model, data, frame);
  S* column = jacobian + 6 * support_size(model, joint);
  if (axes == FrameAxes::local) {
    for (int j = joint; j >= 0; j = model.joints[j].parent)
      if (model.joints[j].type == JointType::floating)
        store_base_columns(m, column -= 36);
      else
        store(act_inverse(m, data.axis[j]), column -= 6);
    return;
  }
  const Matrix3<S> r = world_rotation(model, data, joint, m, axes);
  for_each_axis(model, data, joint, [&](const Motion<S>& axis, int) {
    store(rotate(r, act_inverse(m, axis)), column -= 6);
  });
}

template <class S>
void frame_position_jacobian(const RobotModel& model, const RobotData<S>& data, int frame,
                             S* jacobian) {
  const int joint = model.frames[frame].joint;
  if (joint < 0) return;
  const Vector3<S> p = placement_in_root(model, data, frame).p;
  const Matrix3<S> r = data.root_pose(model, joint).R;
  S* column = jacobian + 3 * support_size(model, joint);
  for_each_axis(model, data, joint, [&](const Motion<S>& axis, int) {
    const Vector3<S> shift = r * (axis.linear + cross(axis.angular, p));
    column -= 3;
    for (int i = 0; i < 3; ++i) column[i] = shift[i];
  });
}

template <class S>
void frame_rotation_jacobian(const RobotModel& model, const RobotData<S>& data, int frame,
                             S* jacobian) {
  const int joint = model.frames[frame].joint;
  if (joint < 0) return;
  const Matrix3<S> r = placement_in_root(model, data, frame).R;
  S* column = jacobian + 3 * support_size(model, joint);
  for_each_axis(model, data, joint, [&](const Motion<S>& axis, int) {
    const Vector3<S> turn = transpose_times(r, axis.angular);
    column -= 3;
    for (int i = 0; i < 3; ++i) column[i] = turn[i];
  });
}

template <class S>
void frame_velocity_derivative(const RobotModel& model, const RobotData<S>& data, int frame,
                               FrameAxes axes, S* velocity_q) {
  const int joint = model.frames[frame].joint;
  if (joint < 0) return;
  const SE3<S> m = placement_in_root(model, data, frame);
  const Matrix3<S> r = world_rotation(model, data, joint, m, axes);
  const Motion<S> local = act_inverse(m, data.v[joint]);
  S* column = velocity_q + 6 * support_size(model, joint);
  for_each_axis(model, data, joint, [&](const Motion<S>& axis, int j) {
    Motion<S> change = model.joints[j].type == JointType::floating
                           ? Motion<S>::zero()
                           : act_inverse(m, data.psi_dot[j]);
    if (axes == FrameAxes::world_aligned) {
      const Vector3<S> turn = act_inverse(m, axis).angular;
      change = rotate(r, change + Motion<S>{cross(turn, local.linear), cross(turn, local.angular)});
    }
    store(change, column -= 6);
  });
}

template <class S>
void frame_acceleration_derivatives(const RobotModel& model, const RobotData<S>& data, int frame,
                                    S* acceleration_q, S* acceleration_v) {
  const int joint = model.frames[frame].joint;
  if (joint < 0) return;
  const SE3<S> m = placement_in_root(model, data, frame);
  const Motion<S>& v = data.v[joint];
  const int end = 6 * support_size(model, joint);
  S* column_q = acceleration_q + end;
  S* column_v = acceleration_v + end;
  const Vector3<S> g = data.gravity(model, joint);
  for_each_axis(model, data, joint, [&](const Motion<S>& axis, int j) {
    if (model.joints[j].type == JointType::floating) {
      store(Motion<S>::zero(), column_q -= 6);
      store(act_inverse(m, cross(data.v[j] - v, axis)), column_v -= 6);
      return;
    }
    // data.a omits gravity, which rotates with the joint as seen from the frame.
    const Motion<S> fall = cross(Motion<S>{g, Vector3<S>::zero()}, axis);
    store(act_inverse(m, data.psi_ddot[j] + fall - cross(v, data.psi_dot[j])), column_q -= 6);
    store(act_inverse(m, data.axis_rate[j] - cross(v, axis)), column_v -= 6);
  });
}

template <class S>
Vector3<S> center_of_mass(const RobotModel& model, const RobotData<S>& data) {
  Vector3<S> moment = Vector3<S>::zero();
  S mass(0.0);
  for (int i = 0; i < model.joint_count(); ++i) {
    if (model.joints[i].parent >= 0) continue;
    const SE3<S> root = data.root_pose(model, i);
    moment += root.R * data.composite[i].moment + data.composite[i].mass * root.p;
    mass += data.composite[i].mass;
  }
  return (S(1.0) / mass) * moment;
}

namespace {

/// First moment of mass of a load's unit about the center of mass, in world axes.
template <class S>
Vector3<S> first_moment(const RobotModel& model, const RobotData<S>& data, const Load& load,
                        const Inertia<S>& unit) {
  const SE3<S> root = data.root_pose(model, load.body);
  return root.R * unit.moment + unit.mass * (root.p - center_of_mass(model, data));
}

}  // namespace

template <class S>
void center_of_mass_jacobian(const RobotModel& model, const RobotData<S>& data, S* jacobian) {
  S mass(0.0);
  for (int i = 0; i < model.joint_count(); ++i)
    if (model.joints[i].parent < 0) mass += data.composite[i].mass;
  const S inverse = S(1.0) / mass;
  for (int i = 0; i < model.joint_count(); ++i) {
    const Matrix3<S> r = data.root_pose(model, i).R;
    S* column = jacobian + 3 * model.joints[i].v;
    const auto put = [&](const Vector3<S>& l) {
      const Vector3<S> world = inverse * (r * l);
      for (int k = 0; k < 3; ++k) *column++ = world[k];
    };
    if (model.joints[i].type != JointType::floating) {
      put(data.column[i].linear);
      continue;
    }
    for (int k = 0; k < 6; ++k) {
      Motion<S> e = Motion<S>::zero();
      e[k] = S(1.0);
      put((data.composite[i] * e).linear);
    }
  }
  for_each_load(model, data, [&](const Load& load, const Inertia<S>& unit) {
    const Vector3<S> change = inverse * first_moment(model, data, load, unit);
    for (int k = 0; k < 3; ++k) jacobian[3 * model.joints[load.parameter].v + k] += change[k];
  });
}

template <class S>
Force<S> centroidal_momentum(const RobotModel& model, const RobotData<S>& data) {
  const Vector3<S> com = center_of_mass(model, data);
  Force<S> total = Force<S>::zero();
  for (int i = 0; i < model.joint_count(); ++i) {
    const SE3<S> root = data.root_pose(model, i);
    total += act(SE3<S>{root.R, root.p - com}, data.body[i] * data.v[i]);
  }
  return total;
}

namespace {

/// Accumulates the momenta of the subtrees.
template <class S>
void gather_momenta(const RobotModel& model, RobotData<S>& data) {
  for (int i = 0; i < model.joint_count(); ++i) data.momentum[i] = data.body[i] * data.v[i];
  for (int i = model.joint_count() - 1; i >= 0; --i)
    if (model.joints[i].parent >= 0) data.momentum[model.joints[i].parent] += data.momentum[i];
}

}  // namespace

template <class S>
void centroidal_momentum_derivatives(const RobotModel& model, RobotData<S>& data, S* wrt_q,
                                     S* wrt_v) {
  gather_momenta(model, data);
  const Vector3<S> com = center_of_mass(model, data);
  S mass(0.0);
  Vector3<S> linear = Vector3<S>::zero();
  for (int i = 0; i < model.joint_count(); ++i) {
    if (model.joints[i].parent >= 0) continue;
    mass += data.composite[i].mass;
    linear += data.root_pose(model, i).R * data.momentum[i].linear;
  }
  const S inverse = S(1.0) / mass;
  for (int i = 0; i < model.joint_count(); ++i) {
    const SE3<S> root = data.root_pose(model, i);
    const SE3<S> to_com{root.R, root.p - com};
    S* q = wrt_q + 6 * model.joints[i].v;
    S* v = wrt_v + 6 * model.joints[i].v;
    // column: momentum of the subtree per unit velocity; change: that of momentum at fixed
    // velocity.
    const auto put = [&](const Force<S>& column, const Force<S>& change) {
      const Force<S> a = act(to_com, column);
      Force<S> b = act(to_com, change);
      // The reference point of angular momentum, the center of mass, moves too.
      b.angular += cross(linear, inverse * a.linear);
      for (int k = 0; k < 6; ++k) {
        *v++ = a[k];
        *q++ = b[k];
      }
    };
    if (model.joints[i].type != JointType::floating) {
      put(data.column[i],
          cross(data.axis[i], data.momentum[i]) + data.composite[i] * data.psi_dot[i]);
      continue;
    }
    for (int k = 0; k < 6; ++k) {
      Motion<S> e = Motion<S>::zero();
      e[k] = S(1.0);
      put(data.composite[i] * e, cross(e, data.momentum[i]));
    }
  }
  for_each_load(model, data, [&](const Load& load, const Inertia<S>& unit) {
    const SE3<S> root = data.root_pose(model, load.body);
    Force<S> change = act(SE3<S>{root.R, root.p - com}, unit * data.v[load.body]);
    change.angular += cross(linear, inverse * first_moment(model, data, load, unit));
    for (int k = 0; k < 6; ++k) wrt_q[6 * model.joints[load.parameter].v + k] += change[k];
  });
}

#define CONDDP_INSTANTIATE(S)                                                                     \
  template SE3<S> frame_placement(const RobotModel&, const RobotData<S>&, int);                   \
  template Motion<S> frame_velocity(const RobotModel&, const RobotData<S>&, int, FrameAxes);      \
  template Motion<S> frame_acceleration(const RobotModel&, const RobotData<S>&, int, FrameAxes);  \
  template void frame_jacobian(const RobotModel&, const RobotData<S>&, int, FrameAxes, S*);       \
  template void frame_position_jacobian(const RobotModel&, const RobotData<S>&, int, S*);         \
  template void frame_rotation_jacobian(const RobotModel&, const RobotData<S>&, int, S*);         \
  template void frame_velocity_derivative(const RobotModel&, const RobotData<S>&, int, FrameAxes, \
                                          S*);                                                    \
  template void frame_acceleration_derivatives(const RobotModel&, const RobotData<S>&, int, S*,   \
                                               S*);                                               \
  template Vector3<S> center_of_mass(const RobotModel&, const RobotData<S>&);                     \
  template void center_of_mass_jacobian(const RobotModel&, const RobotData<S>&, S*);              \
  template Force<S> centroidal_momentum(const RobotModel&, const RobotData<S>&);                  \
  template void centroidal_momentum_derivatives(const RobotModel&, RobotData<S>&, S*, S*);
CONDDP_FOR_EACH_KERNEL_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
