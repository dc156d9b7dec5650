#pragma once

#include <string>

#include "robot/data.hpp"
#include "robot/frames.hpp"

namespace conddp {

/// The motion of its frame that a contact constrains: along one direction, along two, of the point,
/// or of the whole frame. The number of rows is 1, 2, 3 or 6.
enum class ContactKind { normal, planar, point, surface };

/// A frame in contact with the world: its chosen velocity components must stay zero.
///
/// Rows are in the frame's axes, except for `normal` and `planar`, whose rows are along the
/// directions below. At the acceleration level (Baumgarte 1972):
///   a + kd·v + kp·error = 0.
/// Here a is the acceleration of the point (normal, planar, point) or the rate of the twist
/// (surface). The error is that of the position, or log(reference⁻¹ placement).
struct Contact {
  std::string name;
  int frame = 0;
  ContactKind kind = ContactKind::point;
  FrameAxes axes = FrameAxes::world_aligned;  ///< the directions below are fixed in these axes
  Vector3<double> normal{0, 0, 1};            ///< unit vector
  Vector3<double> tangent{1, 0, 0};           ///< unit vector; planar contacts only
  double kp = 0;                              ///< 1/s²
  double kd = 0;                              ///< 1/s
  SE3<double> reference = SE3<double>::identity();  ///< in the world; used if kp is not 0

  int rows() const {
    switch (kind) {
      case ContactKind::normal:
        return 1;
      case ContactKind::planar:
        return 2;
      case ContactKind::point:
        return 3;
      case ContactKind::surface:
        break;
    }
    return 6;
  }
};

/// A contact's quantities in one configuration. Matrices are by columns, which correspond to
/// support(model, joint of the frame).
template <class S>
struct ContactData {
  ContactData(const RobotModel& model, const Contact& contact);

  SE3<S> placement;                 ///< of the frame in the root frame
  SE3<S> world;                     ///< of the frame in the world
  Vector3<S> directions[2];         ///< normal and planar contacts, in the frame's axes
  AlignedVector<S> frame_jacobian;  ///< 6 x columns, in local axes
  AlignedVector<S> jacobian;        ///< rows() x columns
  AlignedVector<S> wrt_q, wrt_v;    ///< rows() x columns: of the acceleration or velocity
  AlignedVector<S> scratch;         ///< 18 x columns
  Force<S> local;                   ///< force and torque on the robot, in the frame
};

/// Writes everything up to `jacobian`; placements must be current.
template <class S>
void update_contact(const RobotModel& model, const Contact& contact, const RobotData<S>& data,
                    ContactData<S>& out);

/// Writes the rows of a + kd·v + kp·error; accelerations and the contact must be current.
template <class S>
void contact_acceleration(const RobotModel& model, const Contact& contact, const RobotData<S>& data,
                          const ContactData<S>& at, S* rows);
/// Writes their derivatives with respect to configuration and velocity, at fixed generalized
/// accelerations, into wrt_q and wrt_v. Derivative columns must be current.
template <class S>
void contact_acceleration_derivatives(const RobotModel& model, const Contact& contact,
                                      const RobotData<S>& data, ContactData<S>& at);

/// Writes the derivative of the velocity rows (jacobian times generalized velocity) with respect to
/// the configuration into wrt_q; velocities must be current.
template <class S>
void contact_velocity_derivative(const RobotModel& model, const Contact& contact,
                                 const RobotData<S>& data, ContactData<S>& at);

/// Writes `local` from the forces of the rows.
template <class S>
void set_contact_force(const Contact& contact, const S* rows, ContactData<S>& at);
/// Adds the contact's wrench to the forces on bodies (one per joint, root frame).
template <class S>
void add_contact_wrench(const RobotModel& model, const Contact& contact, const ContactData<S>& at,
                        AlignedVector<Force<S>>& forces);
/// Subtracts the change of Jᵀ·(forces of the rows) from tau_q (nv x nv by columns, as in RobotData)
/// for directions fixed in the world, which rotate relative to the body. No effect on other
/// contacts.
template <class S>
void subtract_direction_derivative(const RobotModel& model, const Contact& contact,
                                   const ContactData<S>& at, AlignedVector<S>& tau_q);

/// The same contracted with w (nv): subtracts the gradient of wᵀ Jᵀ·(forces of the rows) from wrt_q
/// (nv).
template <class S>
void subtract_direction_gradient(const RobotModel& model, const Contact& contact,
                                 const ContactData<S>& at, const S* w, AlignedVector<S>& wrt_q);

/// The force and torque on the robot in world axes, at the frame's origin (N, Nm).
template <class S>
Force<S> contact_force_in_world(const ContactData<S>& at) {
  return {at.world.R * at.local.linear, at.world.R * at.local.angular};
}

}  // namespace conddp
