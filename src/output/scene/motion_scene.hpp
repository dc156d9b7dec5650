#pragma once

#include "base/json/json_text.hpp"
#include "ocp/problem/trajectory.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// What a viewer needs to draw the robots of a problem along a trajectory, so that it needs no
/// kinematics of its own (null for systems that cannot be drawn, see closed_form_scene()):
///   bodies: name, parent, shapes; stand_ins: links that are not drawn by their visual shapes (see
///           robot_shapes.hpp);
///   poses: per node the position and quaternion (x y z w) of every body in the world, one list;
///   contacts: name, the body that carries it and the placement there, friction, half_size, and per
///           node the position and the normal; the force acts `radius` below the placement, in the
///           state `acts_after` nodes after the beginning of its knot, and the robot stands there
///           if it is `ground`;
///   com: per node; paths: per node the positions of the frames that costs and constraints speak
///   of; obstacles and collision_shapes: see scene_obstacles.hpp.
/// Lengths in metres, rounded to a micrometre.
OrderedJson motion_scene(const ProblemSpec& spec, const BuiltProblem& built,
                         const Trajectory& trajectory);

}  // namespace conddp
