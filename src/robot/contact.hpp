#pragma once

#include <string>
#include <vector>

#include "robot/data.hpp"
#include "robot/frames.hpp"
#include "robot/relative_frames.hpp"

namespace conddp {

/// The motion of its frame that a contact constrains: along one direction, along two, of the point,
/// or of the whole frame. The number of rows is 1, 2, 3 or 6.
enum class ContactKind { normal, planar, point, surface };

/// A frame in contact with its base: the world, or another frame. Chosen components of its velocity
/// relative to the base must stay zero. A contact with another frame closes a loop of joints.
///
/// Rows are in the frame's axes, except for `normal` and `planar`, whose rows are along the
/// directions below. At the acceleration level (Baumgarte 1972):
///   a + kd·v + kp·error = 0.
/// Here a is the acceleration of the point (normal, planar, point) or the rate of the twist
/// (surface), as seen from the base. The error is that of the position, or log(reference⁻¹
/// placement).
struct Contact {
  std::string name;
  int frame = 0;
  std::optional<int> base = {};  ///< the frame that is touched; absent: the world
  ContactKind kind = ContactKind::point;
  /// The directions below are fixed in the axes of the frame, or in those of the base.
  FrameAxes axes = FrameAxes::world_aligned;
  Vector3<double> normal{0, 0, 1};                  ///< unit vector
  Vector3<double> tangent{1, 0, 0};                 ///< unit vector; planar contacts only
  double kp = 0;                                    ///< 1/s²
  double kd = 0;                                    ///< 1/s
  SE3<double> reference = SE3<double>::identity();  ///< in the base; used if kp is not 0

  FramePair pair() const { return {frame, base}; }
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
/// support(model, contact.pair()).
template <class S>
struct ContactData {
  ContactData(const RobotModel& model, const Contact& contact);

  std::vector<int> support;         ///< velocity indices of the columns
  SE3<S> placement;                 ///< of the frame in the root frame
  SE3<S> world;                     ///< of the frame in the world
  SE3<S> relative;                  ///< of the frame in the base
  SE3<S> base_placement;            ///< of a moving base in its root frame
  Vector3<S> directions[2];         ///< normal and planar contacts, in the frame's axes
  AlignedVector<S> frame_jacobian;  ///< 6 x columns: twist relative to the base, in local axes
  AlignedVector<S> base_jacobian;   ///< 6 x columns: the part of a moving base in it, or empty
  AlignedVector<S> jacobian;        ///< rows() x columns
  AlignedVector<S> wrt_q, wrt_v;    ///< rows() x columns: of the acceleration or velocity
  AlignedVector<S> scratch;         ///< 18 x columns; with a moving base for both frames, too
  Force<S> local;                   ///< force and torque on the robot, in the frame
};

/// Writes everything up to `jacobian`; placements must be current.
template <class S>
void update_contact(const RobotModel& model, const Contact& contact, const RobotData<S>& data,
                    ContactData<S>& out);

/// Writes the rows of the error; the contact must be current.
template <class S>
void contact_error(const Contact& contact, const ContactData<S>& at, S* rows);

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
/// that forces fixed to their bodies do not have. Directions fixed in the base rotate relative to
/// the body, and forces on the base move relative to it. No effect on other contacts.
template <class S>
void subtract_contact_derivative(const RobotModel& model, const Contact& contact,
                                 const ContactData<S>& at, AlignedVector<S>& tau_q);

/// The same contracted with w (nv): subtracts the gradient of wᵀ Jᵀ·(forces of the rows) from wrt_q
/// (nv).
template <class S>
void subtract_contact_gradient(const RobotModel& model, const Contact& contact,
                               const ContactData<S>& at, const S* w, AlignedVector<S>& wrt_q);

/// The force and torque on the frame's body at the frame's origin (N, Nm), in axes of the base.
template <class S>
Force<S> contact_force_in_base(const ContactData<S>& at) {
  return {at.relative.R * at.local.linear, at.relative.R * at.local.angular};
}
/// The same in world axes.
template <class S>
Force<S> contact_force_in_world(const ContactData<S>& at) {
  return {at.world.R * at.local.linear, at.world.R * at.local.angular};
}

}  // namespace conddp
