#pragma once

#include <memory>
#include <vector>

#include "robot/data.hpp"
#include "robot/model.hpp"
#include "spatial/dual.hpp"
#include "systems/contact/contact_candidate.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {

/// A robot, whose base may float, and its possible contacts.
struct ContactPlant {
  std::shared_ptr<const RobotModel> robot;
  std::vector<double> B;        ///< nv x nu, column-major: generalized forces of the controls
  std::vector<double> damping;  ///< nv, N s/m or Nm s/rad; empty: none
  /// Smoothed friction −smooth_friction·tanh(v / friction_velocity): nv, N or Nm; empty: none.
  std::vector<double> smooth_friction;
  double friction_velocity = 0.01;  ///< m/s or rad/s
  ImplicitContacts contacts;

  int nq() const { return robot->nq; }
  int nv() const { return robot->nv; }
  int nu() const { return nv() == 0 ? 0 : static_cast<int>(B.size()) / nv(); }
  /// The generalized forces B u.
  std::vector<double> applied(const double* u) const;
};

/// Plant of a robot without mimic joints, with its actuators and passive forces.
ContactPlant contact_plant(const MultibodySystem& robot, ImplicitContacts contacts);

/// Number of friction tangents of a candidate: 0 without friction, 1 in a plane, 2 in space.
int tangent_count(const ImplicitContacts& contacts, const ContactCandidate& candidate);

/// One candidate in one configuration. The normal points from the touched body to the sphere;
/// forces and velocities are those of the sphere. In a plane, the tangent is plane × normal; in
/// space, both tangents follow from the normal by Duff et al. (2017).
template <class S>
struct ContactInstant {
  S gap;                     ///< m
  Vector3<S> directions[3];  ///< normal and tangents, in the world
  Vector3<S> point;          ///< on the sphere, in the world
  /// 3 x nv, row-major: velocity of the sphere's point relative to the opposite point, along each
  /// direction. Rows of missing tangents are zero.
  std::vector<S> rows;
};

/// Mechanics of a plant in scalar arithmetic, used by checks only: kinematics and inverse dynamics
/// of the robot, and the gaps and directions of contacts. Defined for double and Dual<double>.
template <class S>
class ContactMechanics {
 public:
  explicit ContactMechanics(const ContactPlant& plant);

  /// Evaluates gaps, directions and rows of all candidates at q.
  const std::vector<ContactInstant<S>>& look(const S* q);
  /// M(q) a + c(q, v) + resistance(v) minus external wrenches: nv numbers.
  const std::vector<S>& load(const S* q, const S* v, const S* a);
  /// Resisting force of damping and smoothed friction in joint i.
  S resistance(int i, const S& v) const;
  /// ∂T/∂q of the kinetic energy T = ½ vᵀ M(q) v at fixed v. The entry of a joint is the product of
  /// its subtree's momentum and the rate of the joint's axis.
  const std::vector<S>& kinetic_slope(const S* q, const S* v);

 private:
  /// Placement of a body and motion of its points: 6 x nv, row-major (linear at `origin`; angular).
  struct Body {
    SE3<S> placement = SE3<S>::identity();
    Vector3<S> origin = Vector3<S>::zero();
    std::vector<S> rows;
  };
  Body body(int frame, const SE3<double>& local);
  /// Computes the signed distance and the normal.
  void touch(const ContactCandidate& candidate, const Vector3<S>& center, const SE3<S>& other,
             ContactInstant<S>& out) const;
  void complete(ContactInstant<S>& out) const;

  const ContactPlant& plant_;
  RobotData<S> data_;
  std::vector<ContactInstant<S>> instants_;
  std::vector<S> load_, slope_;
};

/// q⁺ = q ⊕ d for tangent vectors d (h v⁺ of a step; nv numbers), used by checks only. Joints with
/// one degree of freedom add; floating bases turn and move along the screw of d in their own frame.
/// Defined for double and Dual<double>.
template <class S>
void move_configuration(const RobotModel& robot, const double* q, const S* d, S* moved);

/// Solves q ⊕ d = to for d; for floating bases, d is the screw between the two poses.
void configuration_difference(const RobotModel& robot, const double* q, const double* to,
                              double* d);

}  // namespace conddp
