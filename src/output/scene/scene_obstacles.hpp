#pragma once

#include "base/json/ordered_json.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// What stands in the way of a motion or bounds it, for motion_scene(), in world axes (m):
///   sphere: center, radius; capsule: from, to, radius; half_space: normal, point;
///   disc (of motions in a plane): center, normal of the plane, radius;
///   box (bounds on a position): lower, upper, null along an axis without a bound.
/// Obstacles of `collision` come first, then constraints on positions of frames, of the centre of
/// mass, or of coordinates that are positions in the world: `inside` is whether the motion has to
/// stay inside. A center that moves is `centers` instead, a list over the nodes; bounds that move
/// are left out.
OrderedJson obstacles_json(const ProblemSpec& spec, const BuiltProblem& built);

/// The shapes of `collision` that bodies carry: name, body (0: the world, else the joint after
/// which it comes plus one), sphere or capsule as above in the body's axes.
OrderedJson collision_shapes_json(const ProblemSpec& spec, const RobotModel& robot);

}  // namespace conddp
