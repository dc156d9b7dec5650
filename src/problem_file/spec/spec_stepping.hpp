#pragma once

#include <array>
#include <variant>

#include "problem_file/spec/spec_collision.hpp"
#include "systems/contact/contact_candidate.hpp"

namespace conddp {

struct BoxSpec {
  Vector3<double> size{1, 1, 1};  ///< m
  PoseSpec placement;             ///< of its middle, in the frame or in the world
};

/// What a candidate may touch, carried by a frame or standing in the world.
struct TouchedSpec {
  Place place;
  std::optional<Name> frame;
  std::variant<HalfSpaceSpec, SphereSpec, BoxSpec> form;
};

/// A point or sphere of the robot that may touch something at any time.
struct CandidateSpec {
  Name name;
  Name frame;
  Vector3<double> point = Vector3<double>::zero();  ///< the sphere's centre, in the frame, m
  double radius = 0;                                ///< m
  TouchedSpec against;
  double friction = 0.5;
  std::optional<double> stiffness;  ///< N/m
};

/// Steps that find out themselves which contacts are closed.
struct SteppingSpec {
  Place place;
  SteppingScheme scheme = SteppingScheme::backward_euler;
  FrictionModel friction = FrictionModel::polyhedron;
  std::optional<Vector3<double>> plane;  ///< unit normal
  bool all_limits = false;               ///< every joint's limits of the URDF are stops
  std::vector<std::pair<Name, std::array<double, 2>>> joint_limits;
  NamedNumbers joint_friction;
  /// Weight of ½ f², of forces, slip speeds and shares of friction, a rate.
  double regularization = 1e-3;
};

}  // namespace conddp
