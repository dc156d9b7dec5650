#pragma once

#include <span>

#include "base/json/ordered_json.hpp"
#include "ocp/problem/trajectory.hpp"
#include "problem_file/assemble/build.hpp"

namespace conddp {

/// Data with which a viewer draws the robots of a problem along a trajectory without kinematics of
/// its own (null for systems that cannot be drawn, see closed_form_scene()):
///   bodies: name, parent, shapes; stand_ins: links not drawn by their visual shapes (see
///           robot_shapes.hpp);
///   poses: per node the position and quaternion (x y z w) of every body in the world, one list;
///   contacts: name, carrying body and placement on it, friction, half_size, and per node the
///           position and the normal; the force acts `radius` below the placement, in the
///           state `acts_after` nodes after the beginning of its knot, and the robot stands there
///           if it is `ground`;
///   com: per node; paths: per node the positions of the frames in costs and constraints, and of
///   moving drawings;
///   obstacles and collision_shapes: see scene_obstacles.hpp.
/// Drawings of the file add bodies, whose shapes may also be a dot, obstacles that are `scenery`,
/// and `lines`: name, number of corners, and their positions, corner after corner, per node. A
/// scene with drawings is `planar` if all of them are given by x and y, and nothing else moves.
/// Lengths in meters, rounded to a micrometer. `knots`: the problem's knot at each node; empty: the
/// nodes are those of the problem.
OrderedJson motion_scene(const BuiltProblem& built, const Trajectory& trajectory,
                         std::span<const int> knots = {});

}  // namespace conddp
