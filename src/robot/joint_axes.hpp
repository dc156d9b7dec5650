#pragma once

#include "robot/data.hpp"

namespace conddp {

/// Pose of a frame in its root frame; of a fixed frame in the world.
template <class S>
SE3<S> placement_in_root(const RobotModel& model, const RobotData<S>& data, int frame) {
  const Frame& f = model.frames[frame];
  return f.joint < 0 ? f.placement.cast<S>() : data.placement[f.joint] * f.placement;
}

/// Columns of six rows as motions.
template <class S>
void store_column(const Motion<S>& m, S* columns, int c) {
  for (int i = 0; i < 6; ++i) columns[6 * c + i] = m[i];
}

template <class S>
Motion<S> load_column(const S* columns, int c) {
  const S* p = columns + 6 * c;
  return {{p[0], p[1], p[2]}, {p[3], p[4], p[5]}};
}

/// Calls column(motion in root coordinates, joint) for every velocity index that moves a joint's
/// body, from the tip to the root, or to a joint before the root, which is left out. A floating
/// base contributes six unit motions.
template <class S, class F>
void for_each_axis(const RobotModel& model, const RobotData<S>& data, int joint, int end,
                   F column) {
  for (int j = joint; j != end; j = model.joints[j].parent) {
    if (model.joints[j].type == JointType::floating) {
      for (int k = 5; k >= 0; --k) {
        Motion<S> e = Motion<S>::zero();
        e[k] = S(1.0);
        column(e, j);
      }
    } else {
      column(data.axis[j], j);
    }
  }
}
template <class S, class F>
void for_each_axis(const RobotModel& model, const RobotData<S>& data, int joint, F column) {
  for_each_axis(model, data, joint, -1, column);
}

}  // namespace conddp
