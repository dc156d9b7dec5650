#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "robot/model.hpp"

namespace conddp {

/// Contacts that the trajectory may make and break at any time; the contact sequence is part of the
/// solution.

/// A sphere, or a point if the radius is 0, fixed to a frame of the robot or to the world.
struct ContactSphere {
  int frame = -1;                                    ///< of the robot; −1: the world
  Vector3<double> center = Vector3<double>::zero();  ///< in the frame's axes, m
  double radius = 0;                                 ///< m
};
/// The points p with normal·p ≤ offset, in the axes of a frame or of the world; the normal is a
/// unit vector.
struct ContactHalfSpace {
  int frame = -1;
  Vector3<double> normal{0, 0, 1};
  double offset = 0;  ///< m
};
/// A box centered at the origin of `placement`, which is given in the axes of a frame or of the
/// world.
struct ContactBox {
  int frame = -1;
  SE3<double> placement = SE3<double>::identity();
  Vector3<double> half_sizes{0.5, 0.5, 0.5};  ///< m
};

/// A pair that may touch: a sphere and an opposite shape. The normal n points from that shape
/// towards the sphere. Rigid: 0 ≤ f_n ⊥ φ ≥ 0; soft: 0 ≤ f_n ⊥ φ + f_n/stiffness ≥ 0.
struct ContactCandidate {
  std::string name;
  ContactSphere sphere;
  std::variant<ContactHalfSpace, ContactSphere, ContactBox> against;
  double friction = 0;              ///< Coulomb's μ; 0: no friction and no tangents
  std::optional<double> stiffness;  ///< N/m; without it the contact is rigid
};

/// A joint's own limits as stops: 0 ≤ f ⊥ q − lower ≥ 0, and likewise above.
struct JointStop {
  int joint = 0;
  double lower = -kUnlimited, upper = kUnlimited;  ///< rad or m
};
/// Dry friction of a joint: the maximally dissipative force within ± limit.
struct JointFriction {
  int joint = 0;
  double limit = 0;  ///< N or Nm
};

/// The time-stepping scheme for these forces, which act at the end of the step.
/// - backward_euler: M(q⁺)(v⁺ − v)/h + c(q⁺, v⁺) = B u + J(q⁺)ᵀ f, q⁺ = q ⊕ h v⁺;
/// - variational_midpoint: the discrete Euler-Lagrange equations of the midpoint rule.
enum class SteppingScheme { backward_euler, variational_midpoint };
/// The bound on friction: a pyramid with both signs of each tangent, or the exact cone.
enum class FrictionModel { polyhedron, cone };

/// All contacts, stops and friction in the stepping equations of a robot.
struct ImplicitContacts {
  std::vector<ContactCandidate> candidates;
  std::vector<JointStop> stops;
  std::vector<JointFriction> frictions;
  SteppingScheme scheme = SteppingScheme::backward_euler;
  FrictionModel friction = FrictionModel::polyhedron;
  /// The unit normal of the plane of motion of a planar robot: contacts have a single tangent,
  /// normal × n. In space they have two.
  std::optional<Vector3<double>> plane;
};

}  // namespace conddp
