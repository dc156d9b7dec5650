#pragma once

#include <vector>

#include "systems/system.hpp"

namespace conddp {

/// Names and units of the ndx components of a tangent vector. Rotations have the names of their
/// quaternion's first components, with r in the place of q, and rad.
std::vector<Column> tangent_columns(const System& system);

}  // namespace conddp
