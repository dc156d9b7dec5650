#pragma once

#include <vector>

#include "systems/system.hpp"

namespace conddp {

/// Names and units of the ndx components of a tangent vector. Rotations take the names of their
/// quaternion's first three components, with r in place of q, and the unit rad.
std::vector<Column> tangent_columns(const System& system);

}  // namespace conddp
