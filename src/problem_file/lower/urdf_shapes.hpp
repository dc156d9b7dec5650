#pragma once

#include "problem_file/model/spec.hpp"

namespace conddp {

/// Adds the collision shapes of the robots' URDFs to those of the file (`collision: {from: urdf}`).
/// A shape has the name of its link, further ones of the link `/2`, `/3` behind it; one that the
/// file has, too, is the file's. Reports meshes that cannot be read, obstacles with the name of a
/// shape, and URDFs without a shape; warns of geometries that it does not know.
void add_urdf_shapes(ProblemSpec& spec, Diagnostics& out);

}  // namespace conddp
