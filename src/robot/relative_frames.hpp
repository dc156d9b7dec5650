#pragma once

#include <optional>
#include <vector>

#include "robot/frames.hpp"

namespace conddp {

/// A frame as seen from its base: another frame of the model, or the world.
struct FramePair {
  FramePair(int seen, std::optional<int> from = {}) : frame(seen), base(from) {}

  int frame;
  std::optional<int> base;
};

/// The joints that move the two frames, and their columns: ascending velocity indices, those of
/// both first. Columns of both have no effect on the relative motion.
struct RelativeColumns {
  RelativeColumns(const RobotModel& model, const FramePair& pair);

  int frame_joint, base_joint;  ///< −1: fixed to the world
  int common_joint;             ///< last joint that moves both frames, −1 if there is none
  int common, frame, base;      ///< numbers of columns: of both frames, of each
  int count() const { return frame + base - common; }
  /// Index of a column of the frame, or of the base, among all.
  int of_frame(int c) const {
    return c < common || base_joint > frame_joint ? c : base - common + c;
  }
  int of_base(int c) const {
    return c < common || base_joint < frame_joint ? c : frame - common + c;
  }
};

/// Velocity indices of these columns.
std::vector<int> support(const RobotModel& model, const FramePair& pair);

/// Pose of the frame in its base; placements must be current.
template <class S>
SE3<S> relative_placement(const RobotModel& model, const RobotData<S>& data, const FramePair& pair);
/// Velocity (linear; angular) of the frame relative to its base, at the origin of the frame, in its
/// axes, or in those of the base (world_aligned); velocities must be current.
template <class S>
Motion<S> relative_velocity(const RobotModel& model, const RobotData<S>& data,
                            const FramePair& pair, FrameAxes axes);
/// Its Jacobian in the axes of the frame, 6 x count(): velocity = J v. Placements must be current.
/// `of_base`: the columns that the motion of the base alone would have, also of joints that move
/// both; none if null.
template <class S>
void relative_jacobian(const RobotModel& model, const RobotData<S>& data, const FramePair& pair,
                       S* jacobian, S* of_base = nullptr);
/// Derivative of relative_velocity in the axes of the frame with respect to the configuration, 6 x
/// count(); velocities must be current.
template <class S>
void relative_velocity_derivative(const RobotModel& model, const RobotData<S>& data,
                                  const FramePair& pair, S* velocity_q);

/// Derivatives of the rate of the relative velocity, in the axes of the frame, with respect to
/// configuration and velocity at fixed generalized accelerations, 6 x count(). `jacobian` and
/// `velocity_q`: relative_jacobian, relative_velocity_derivative. `scratch`: 12 x (frame + base)
/// numbers for a base that moves. Derivative columns must be current.
template <class S>
void relative_acceleration_derivatives(const RobotModel& model, const RobotData<S>& data,
                                       const FramePair& pair, const S* jacobian,
                                       const S* velocity_q, S* scratch, S* acceleration_q,
                                       S* acceleration_v);

}  // namespace conddp
