#pragma once

#include <memory>
#include <vector>

#include "robot/data.hpp"
#include "systems/contact/contact_candidate.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {

/// A robot, whose base may float, and what it may touch.
struct ContactPlant {
  std::shared_ptr<const RobotModel> robot;
  std::vector<double> B;        ///< nv x nu by columns: generalised forces of the controls
  std::vector<double> damping;  ///< nv, N s/m or Nm s/rad; empty: none
  /// nv, N or Nm, smoothed: −smooth_friction·tanh(v / friction_velocity); empty: none.
  std::vector<double> smooth_friction;
  double friction_velocity = 0.01;  ///< m/s or rad/s
  ImplicitContacts contacts;

  int nq() const { return robot->nq; }
  int nv() const { return robot->nv; }
  int nu() const { return nv() == 0 ? 0 : static_cast<int>(B.size()) / nv(); }
  /// The generalised forces B u.
  std::vector<double> applied(const double* u) const;
};

/// Of a robot with its actuators and passive forces, which has no joints that mimic others.
ContactPlant contact_plant(const MultibodySystem& robot, ImplicitContacts contacts);

/// How many tangents a candidate's friction has: none, one in a plane, two in space.
int tangent_count(const ImplicitContacts& contacts, const ContactCandidate& candidate);

/// One candidate in one configuration. The normal points from what is touched to the sphere;
/// forces and velocities are those of the sphere. The tangent is plane × normal in a plane; in
/// space the two are those of Duff et al. (2017) to the normal.
template <class S>
struct ContactInstant {
  S gap;                     ///< m
  Vector3<S> directions[3];  ///< normal and tangents, in the world
  Vector3<S> point;          ///< on the sphere, in the world
  /// 3 x nv by rows: the velocity of the sphere's point less that of the opposite one, along each
  /// direction; rows of tangents that a candidate lacks are zero.
  std::vector<S> rows;
};

/// The mechanics of a plant in scalar arithmetic, written for checks alone: kinematics and inverse
/// dynamics of the robot and, from them, gaps and directions of contacts. Defined for double and
/// Dual<double>.
template <class S>
class ContactMechanics {
 public:
  explicit ContactMechanics(const ContactPlant& plant);

  /// Gaps, directions and rows of all candidates at q.
  const std::vector<ContactInstant<S>>& look(const S* q);
  /// M(q) a + c(q, v) + resistance(v), less external wrenches: nv numbers.
  const std::vector<S>& load(const S* q, const S* v, const S* a);
  /// What damping and smoothed friction take from joint i.
  S resistance(int i, const S& v) const;
  /// ∂T/∂q of the kinetic energy T = ½ vᵀ M(q) v at fixed v. What a joint's rotation does to it is
  /// the power of its subtree's momentum on the rate of the joint's axis.
  const std::vector<S>& kinetic_slope(const S* q, const S* v);

 private:
  /// Where a body is and how its points move: 6 x nv by rows (linear at `origin`; angular).
  struct Body {
    SE3<S> placement = SE3<S>::identity();
    Vector3<S> origin = Vector3<S>::zero();
    std::vector<S> rows;
  };
  Body body(int frame, const SE3<double>& local);
  /// Signed distance and normal.
  void touch(const ContactCandidate& candidate, const Vector3<S>& center, const SE3<S>& other,
             ContactInstant<S>& out) const;
  void complete(ContactInstant<S>& out) const;

  const ContactPlant& plant_;
  RobotData<S> data_;
  std::vector<ContactInstant<S>> instants_;
  std::vector<S> load_, slope_;
};

}  // namespace conddp
