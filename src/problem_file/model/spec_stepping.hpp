#pragma once

#include <array>
#include <variant>

#include "problem_file/model/spec_collision.hpp"
#include "systems/contact/contact_candidate.hpp"

namespace conddp {

/// Geometry that a candidate may touch, on a frame or fixed in the world.
struct TouchedSpec {
  Place place;
  std::optional<Name> frame;
  std::variant<HalfSpaceSpec, SphereSpec, BoxSpec> form;
};

/// A point or sphere of the robot that may touch something at any time.
struct CandidateSpec {
  Name name;
  Name frame;
  Vector3<double> point = Vector3<double>::zero();  ///< the sphere's center, in the frame, m
  double radius = 0;                                ///< m
  TouchedSpec against;
  double friction = 0.5;
  std::optional<double> stiffness;  ///< N/m
};

/// Contact-implicit steps, which determine the closed contacts themselves.
struct SteppingSpec {
  Place place;
  SteppingScheme scheme = SteppingScheme::backward_euler;
  FrictionModel friction = FrictionModel::polyhedron;
  std::optional<Vector3<double>> plane;  ///< unit normal
  bool all_limits = false;               ///< all joint limits of the URDF are stops
  std::vector<std::pair<Name, std::array<double, 2>>> joint_limits;
  NamedNumbers joint_friction;
  /// Weight of ½ f² on forces, slip speeds and friction shares; a rate.
  double regularization = 1e-3;
};

}  // namespace conddp
