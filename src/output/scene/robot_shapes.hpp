#pragma once

#include <vector>

#include "base/json/json_text.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// What the robots of a problem look like.
struct RobotShapes {
  /// Per body, the world first: a list of shapes with their placements in the body. Meshes stand as
  /// files where the URDF says, if they are at hand.
  std::vector<OrderedJson> of_body;
  /// The links that their visual shapes alone do not draw: `link`, `drawn_by` ("collision shape",
  /// "inertia ellipsoid", "other visual shapes", "nothing") and `reasons`, a list of `why` and
  /// `what`.
  OrderedJson stand_ins = OrderedJson::array();
};

/// Link by link: its visual shapes; where none can be drawn its collision shapes, else the
/// ellipsoid of its inertia.
RobotShapes robot_shapes(const BuiltProblem& built);

}  // namespace conddp
