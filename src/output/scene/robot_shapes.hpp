#pragma once

#include <vector>

#include "base/json/ordered_json.hpp"
#include "problem_file/assemble/build.hpp"

namespace conddp {

/// Shapes of the robots of a problem.
struct RobotShapes {
  /// Per body, the world first: a list of shapes with their placements on the body. Meshes are read
  /// from the files that the URDF names, if available.
  std::vector<OrderedJson> of_body;
  /// The meshes that shapes refer to (SceneMeshes).
  OrderedJson meshes = OrderedJson::array();
  /// Links not drawn by their visual shapes alone: `link`, `drawn_by` ("collision shape", "inertia
  /// ellipsoid", "other visual shapes", "nothing") and `reasons`, a list of `why` and `what`.
  OrderedJson stand_ins = OrderedJson::array();
};

/// Draws each link by its visual shapes, or if none can be drawn, by its collision shapes, else by
/// its inertia ellipsoid.
RobotShapes robot_shapes(const BuiltProblem& built);

}  // namespace conddp
