#pragma once

#include <variant>

#include "problem_file/model/spec_values.hpp"

namespace conddp {

/// In the axes of a frame, or in the world.
struct SphereSpec {
  double radius = 0;                                 ///< m
  Vector3<double> center = Vector3<double>::zero();  ///< m
};
struct CapsuleSpec {
  double radius = 0;                               ///< m
  Vector3<double> from = Vector3<double>::zero();  ///< m
  Vector3<double> to = Vector3<double>::zero();    ///< m
};
/// The space behind a plane.
struct HalfSpaceSpec {
  Vector3<double> normal{0, 0, 1};                  ///< outward unit vector
  Vector3<double> point = Vector3<double>::zero();  ///< on its surface, m
};

/// A shape on a frame of a robot.
struct ShapeSpec {
  Name name;
  Name frame;
  std::variant<SphereSpec, CapsuleSpec> form;
};
/// A shape fixed in the world.
struct ObstacleSpec {
  Name name;
  std::variant<SphereSpec, CapsuleSpec, HalfSpaceSpec> form;
};

struct CollisionSpec {
  std::vector<ShapeSpec> shapes;
  std::vector<ObstacleSpec> obstacles;
};

}  // namespace conddp
