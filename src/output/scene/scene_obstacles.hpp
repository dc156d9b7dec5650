#pragma once

#include "base/json/ordered_json.hpp"
#include "problem_file/assemble/build.hpp"

namespace conddp {

/// Obstacles and bounds of a motion, for motion_scene(), in world axes (m):
///   sphere: center, radius; capsule: from, to, radius; half_space: normal, point;
///   hull: points, the vertices of a convex body;
///   heights: origin, cell, columns, heights (see HeightMapSpec);
///   disc (for planar motions): center, normal of the plane, radius;
///   box (bounds on a position): lower, upper, null along an unbounded axis.
/// Obstacles of `collision` come first, then pieces of the terrain, with `terrain: true`.
/// Constraints follow on positions of frames, on the center of
/// mass, and on coordinates that are positions in the world: `inside` is true if the motion must
/// stay inside. A moving center becomes `centers`, a list over the nodes; moving bounds are
/// omitted.
OrderedJson obstacles_json(const BuiltProblem& built);

/// The shapes of `collision` on bodies: name, body (0: the world, else the index of its joint plus
/// one), and a sphere, capsule or hull as above in the body's axes.
OrderedJson collision_shapes_json(const CollisionSpec& collision, const RobotModel& robot);

}  // namespace conddp
