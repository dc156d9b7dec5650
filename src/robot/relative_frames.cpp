#include "robot/relative_frames.hpp"

#include <algorithm>
#include <iterator>

#include "robot/joint_axes.hpp"

namespace conddp {
namespace {

bool base_moves(const RobotModel& model, const FramePair& pair) {
  return pair.base && model.frames[*pair.base].joint >= 0;
}

/// Rate of a motion subspace as a joint moves its body; that of a floating base is constant.
template <class S>
Motion<S> axis_change(const RobotModel& model, const RobotData<S>& data, int joint) {
  return model.joints[joint].type == JointType::floating ? Motion<S>::zero() : data.psi_dot[joint];
}

}  // namespace

RelativeColumns::RelativeColumns(const RobotModel& model, const FramePair& pair)
    : frame_joint(model.frames[pair.frame].joint),
      base_joint(pair.base ? model.frames[*pair.base].joint : -1),
      common_joint(frame_joint),
      frame(support_size(model, frame_joint)),
      base(support_size(model, base_joint)) {
  // Parents have smaller indices.
  for (int other = base_joint; common_joint != other;)
    (common_joint > other ? common_joint : other) =
        model.joints[std::max(common_joint, other)].parent;
  common = support_size(model, common_joint);
}

std::vector<int> support(const RobotModel& model, const FramePair& pair) {
  const RelativeColumns columns(model, pair);
  const std::vector<int> frame = support(model, columns.frame_joint);
  const std::vector<int> base = support(model, columns.base_joint);
  std::vector<int> both;
  std::ranges::set_union(frame, base, std::back_inserter(both));
  return both;
}

template <class S>
SE3<S> relative_placement(const RobotModel& model, const RobotData<S>& data,
                          const FramePair& pair) {
  const SE3<S> world = frame_placement(model, data, pair.frame);
  return pair.base ? inverse(frame_placement(model, data, *pair.base)) * world : world;
}

template <class S>
Motion<S> relative_velocity(const RobotModel& model, const RobotData<S>& data,
                            const FramePair& pair, FrameAxes axes) {
  if (!pair.base) return frame_velocity(model, data, pair.frame, axes);
  const SE3<S> m = relative_placement(model, data, pair);
  const Motion<S> local = frame_velocity(model, data, pair.frame, FrameAxes::local) -
                          act_inverse(m, frame_velocity(model, data, *pair.base, FrameAxes::local));
  if (axes == FrameAxes::local) return local;
  return {m.R * local.linear, m.R * local.angular};
}

template <class S>
void relative_jacobian(const RobotModel& model, const RobotData<S>& data, const FramePair& pair,
                       S* jacobian, S* of_base) {
  if (!base_moves(model, pair))
    return frame_jacobian(model, data, pair.frame, FrameAxes::local, jacobian);
  const RelativeColumns columns(model, pair);
  std::fill_n(jacobian, 6 * columns.common, S(0.0));
  if (columns.frame_joint >= 0) {
    const SE3<S> m = placement_in_root(model, data, pair.frame);
    int c = columns.frame;
    for_each_axis(model, data, columns.frame_joint, columns.common_joint,
                  [&](const Motion<S>& axis, int) {
                    store_column(act_inverse(m, axis), jacobian, columns.of_frame(--c));
                  });
  }
  const SE3<S> m =
      placement_in_root(model, data, *pair.base) * relative_placement(model, data, pair);
  int c = columns.base;
  for_each_axis(model, data, columns.base_joint, [&](const Motion<S>& axis, int) {
    const Motion<S> move = -act_inverse(m, axis);
    const int to = columns.of_base(--c);
    if (c >= columns.common) store_column(move, jacobian, to);
    if (of_base != nullptr) store_column(move, of_base, to);
  });
}

/// The velocity is v − X v_base. X moves with the frame relative to its base: with J along the
/// direction of a column, X v_base changes by −J × X v_base.
template <class S>
void relative_velocity_derivative(const RobotModel& model, const RobotData<S>& data,
                                  const FramePair& pair, S* velocity_q) {
  if (!base_moves(model, pair))
    return frame_velocity_derivative(model, data, pair.frame, FrameAxes::local, velocity_q);
  const RelativeColumns columns(model, pair);
  std::fill_n(velocity_q, 6 * columns.common, S(0.0));
  const SE3<S> relative = relative_placement(model, data, pair);
  const Motion<S> of_base =
      act_inverse(relative, frame_velocity(model, data, *pair.base, FrameAxes::local));
  if (columns.frame_joint >= 0) {
    const SE3<S> m = placement_in_root(model, data, pair.frame);
    int c = columns.frame;
    for_each_axis(model, data, columns.frame_joint, columns.common_joint,
                  [&](const Motion<S>& axis, int j) {
                    const Motion<S> own = act_inverse(m, axis_change(model, data, j));
                    store_column(own + cross(act_inverse(m, axis), of_base), velocity_q,
                                 columns.of_frame(--c));
                  });
  }
  const SE3<S> m = placement_in_root(model, data, *pair.base) * relative;
  int c = columns.base;
  for_each_axis(model, data, columns.base_joint, columns.common_joint,
                [&](const Motion<S>& axis, int j) {
                  const Motion<S> own = act_inverse(m, axis_change(model, data, j));
                  store_column(-(own + cross(act_inverse(m, axis), of_base)), velocity_q,
                               columns.of_base(--c));
                });
}

/// The rate is a − X a_base + J v × X v_base. X a_base changes as X v_base does.
template <class S>
void relative_acceleration_derivatives(const RobotModel& model, const RobotData<S>& data,
                                       const FramePair& pair, const S* jacobian,
                                       const S* velocity_q, S* scratch, S* acceleration_q,
                                       S* acceleration_v) {
  if (!base_moves(model, pair))
    return frame_acceleration_derivatives(model, data, pair.frame, acceleration_q, acceleration_v);
  const RelativeColumns columns(model, pair);
  S *own_q = scratch, *own_v = own_q + 6 * columns.frame;
  S *base_q = own_v + 6 * columns.frame, *base_v = base_q + 6 * columns.base;
  if (columns.frame_joint >= 0)
    frame_acceleration_derivatives(model, data, pair.frame, own_q, own_v);
  frame_acceleration_derivatives(model, data, *pair.base, base_q, base_v);
  const SE3<S> relative = relative_placement(model, data, pair);
  const auto in_frame = [&](const Motion<S>& m) { return act_inverse(relative, m); };
  const Motion<S> v = relative_velocity(model, data, pair, FrameAxes::local);
  const Motion<S> of_base = in_frame(frame_velocity(model, data, *pair.base, FrameAxes::local));
  const Motion<S> rate = in_frame(frame_acceleration(model, data, *pair.base, FrameAxes::local));
  // `change`: of X v_base.
  const auto put = [&](int c, const Motion<S>& by_q, const Motion<S>& by_v, const Motion<S>& change,
                       const Motion<S>& change_v) {
    const Motion<S> move = load_column(jacobian, c), turn = load_column(velocity_q, c);
    store_column(by_q + cross(move, rate) + cross(turn, of_base) + cross(v, change), acceleration_q,
                 c);
    store_column(by_v + cross(move, of_base) + cross(v, change_v), acceleration_v, c);
  };
  std::fill_n(acceleration_q, 6 * columns.common, S(0.0));
  std::fill_n(acceleration_v, 6 * columns.common, S(0.0));
  for (int own = columns.common; own < columns.frame; ++own) {
    const int c = columns.of_frame(own);
    put(c, load_column(own_q, own), load_column(own_v, own),
        -cross(load_column(jacobian, c), of_base), Motion<S>::zero());
  }
  for (int own = columns.common; own < columns.base; ++own) {
    const int c = columns.of_base(own);
    put(c, -in_frame(load_column(base_q, own)), -in_frame(load_column(base_v, own)),
        -load_column(velocity_q, c), -load_column(jacobian, c));
  }
}

#define CONDDP_INSTANTIATE(S)                                                                    \
  template SE3<S> relative_placement(const RobotModel&, const RobotData<S>&, const FramePair&);  \
  template Motion<S> relative_velocity(const RobotModel&, const RobotData<S>&, const FramePair&, \
                                       FrameAxes);                                               \
  template void relative_jacobian(const RobotModel&, const RobotData<S>&, const FramePair&, S*,  \
                                  S*);                                                           \
  template void relative_velocity_derivative(const RobotModel&, const RobotData<S>&,             \
                                             const FramePair&, S*);                              \
  template void relative_acceleration_derivatives(                                               \
      const RobotModel&, const RobotData<S>&, const FramePair&, const S*, const S*, S*, S*, S*);
CONDDP_FOR_EACH_KERNEL_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
