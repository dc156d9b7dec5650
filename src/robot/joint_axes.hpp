#pragma once

#include "robot/data.hpp"

namespace conddp {

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
