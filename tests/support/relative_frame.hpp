#pragma once

#include <algorithm>
#include <iterator>
#include <optional>
#include <vector>

#include "robot/contact.hpp"
#include "robot/frames.hpp"

namespace conddp {

/// The motion of a frame in world axes.
template <class S>
struct FrameInWorld {
  SE3<S> placement = SE3<S>::identity();
  Motion<S> v = Motion<S>::zero();  ///< of the point, and angular

  FrameInWorld() = default;
  FrameInWorld(const RobotModel& model, const RobotData<S>& data, int frame)
      : placement(frame_placement(model, data, frame)),
        v(frame_velocity(model, data, frame, FrameAxes::world_aligned)) {}
};

/// The motion of a contact's frame as seen from its base, in the base's axes.
template <class S>
struct RelativeFrame {
  SE3<S> placement;
  Motion<S> v;  ///< of the point, and angular

  RelativeFrame(const RobotModel& model, const RobotData<S>& data, const Contact& contact) {
    const FrameInWorld<S> frame(model, data, contact.frame);
    const FrameInWorld<S> base =
        contact.base ? FrameInWorld<S>(model, data, *contact.base) : FrameInWorld<S>();
    const Matrix3<S> to_base = transpose(base.placement.R);
    const Vector3<S> lever = frame.placement.p - base.placement.p;
    placement = {to_base * frame.placement.R, to_base * lever};
    v = {to_base * (frame.v.linear - base.v.linear - cross(base.v.angular, lever)),
         to_base * (frame.v.angular - base.v.angular)};
  }
  /// The twist in the frame's axes.
  Motion<S> twist() const {
    return {transpose_times(placement.R, v.linear), transpose_times(placement.R, v.angular)};
  }
};

/// Some frame with at least so many degrees of freedom between it and a given one, for loops; one
/// on another body if there is none; nullopt if there is no other body.
inline std::optional<int> frame_elsewhere(const RobotModel& model, int frame, int skipped,
                                          std::size_t enough) {
  const std::vector<int> own = support(model, model.frames[frame].joint);
  for (const std::size_t least : {enough, std::size_t{1}}) {
    std::vector<int> others;
    for (int i = 0; i < static_cast<int>(model.frames.size()); ++i) {
      const std::vector<int> other = support(model, model.frames[i].joint);
      std::vector<int> between;
      std::ranges::set_symmetric_difference(own, other, std::back_inserter(between));
      if (between.size() >= least) others.push_back(i);
    }
    if (!others.empty()) return others[skipped % others.size()];
  }
  return std::nullopt;
}

}  // namespace conddp
