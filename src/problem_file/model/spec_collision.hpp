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

struct BoxSpec {
  Vector3<double> size{1, 1, 1};  ///< m
  PoseSpec placement;             ///< of its center, in the frame or in the world
};
struct CylinderSpec {
  double radius = 0;                               ///< m
  Vector3<double> from = Vector3<double>::zero();  ///< center of one end, m
  Vector3<double> to = Vector3<double>::zero();    ///< center of the other, m
};
/// The convex hull of points, expanded by a radius.
struct HullSpec {
  std::vector<Vector3<double>> points = {};  ///< m, in the axes of the placement
  double radius = 0;                         ///< m
  PoseSpec placement = {};                   ///< in the frame or in the world
};

/// A shape on a frame of a robot.
struct ShapeSpec {
  Name name;
  Name frame;
  std::variant<SphereSpec, CapsuleSpec, BoxSpec, CylinderSpec, HullSpec> form;
};
/// A shape fixed in the world.
struct ObstacleSpec {
  Name name;
  std::variant<SphereSpec, CapsuleSpec, HalfSpaceSpec, BoxSpec, CylinderSpec, HullSpec> form;
};

struct CollisionSpec {
  std::optional<Place> from_urdf;  ///< place of `from: urdf`
  std::vector<ShapeSpec> shapes;
  std::vector<ObstacleSpec> obstacles;
  /// Pairs of links whose shapes do not count as self-collisions.
  std::vector<std::pair<std::string, std::string>> disabled;
};

}  // namespace conddp
