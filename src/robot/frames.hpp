#pragma once

#include "robot/data.hpp"

namespace conddp {

/// Velocity indices that move a joint's body (or a frame on it), ascending: the columns of its
/// Jacobians. Empty for the world (joint −1).
std::vector<int> support(const RobotModel& model, int joint);
/// The number of these indices.
int support_size(const RobotModel& model, int joint);

/// Pose of a frame in the world; placements must be current.
template <class S>
SE3<S> frame_placement(const RobotModel& model, const RobotData<S>& data, int frame);

/// Axes for the components of a frame's velocity and acceleration at its origin.
enum class FrameAxes { local, world_aligned };

/// Velocity (linear; angular) of a frame at its origin; velocities must be current.
template <class S>
Motion<S> frame_velocity(const RobotModel& model, const RobotData<S>& data, int frame,
                         FrameAxes axes);
/// Acceleration (linear; angular) without gravity; accelerations must be current. It is spatial:
/// for local axes, the rate of the twist's components. Add ω × v for the acceleration of the point.
template <class S>
Motion<S> frame_acceleration(const RobotModel& model, const RobotData<S>& data, int frame,
                             FrameAxes axes);

/// The columns of derivatives below correspond to support(model, joint of the frame): 6 rows by
/// columns.

/// Jacobian: velocity = J v. Placements must be current.
template <class S>
void frame_jacobian(const RobotModel& model, const RobotData<S>& data, int frame, FrameAxes axes,
                    S* jacobian);
/// Only the linear rows of the world-aligned Jacobian, 3 rows: ∂(position)/∂q.
template <class S>
void frame_position_jacobian(const RobotModel& model, const RobotData<S>& data, int frame,
                             S* jacobian);
/// Only the angular rows of the local Jacobian, 3 rows.
template <class S>
void frame_rotation_jacobian(const RobotModel& model, const RobotData<S>& data, int frame,
                             S* jacobian);
/// Derivative of frame_velocity with respect to the configuration; velocities must be current.
template <class S>
void frame_velocity_derivative(const RobotModel& model, const RobotData<S>& data, int frame,
                               FrameAxes axes, S* velocity_q);
/// Derivatives of frame_acceleration in local axes with respect to configuration and velocity at
/// fixed generalized accelerations; derivative columns must be current. The derivative with respect
/// to the generalized accelerations is frame_jacobian.
template <class S>
void frame_acceleration_derivatives(const RobotModel& model, const RobotData<S>& data, int frame,
                                    S* acceleration_q, S* acceleration_v);

/// Center of mass of all trees in the world (m); composite inertias must be current.
template <class S>
Vector3<S> center_of_mass(const RobotModel& model, const RobotData<S>& data);
/// Its Jacobian, 3 x nv by columns: velocity of the center of mass = J v.
template <class S>
void center_of_mass_jacobian(const RobotModel& model, const RobotData<S>& data, S* jacobian);

/// Momentum (linear; angular) about the center of mass in world axes; velocities and composite
/// inertias must be current.
template <class S>
Force<S> centroidal_momentum(const RobotModel& model, const RobotData<S>& data);
/// Its derivatives with respect to configuration and velocity, 6 x nv by columns. The latter is the
/// centroidal momentum matrix. Writes data.momentum (of subtrees).
template <class S>
void centroidal_momentum_derivatives(const RobotModel& model, RobotData<S>& data, S* wrt_q,
                                     S* wrt_v);

}  // namespace conddp
