#pragma once

#include <string>
#include <vector>

#include "systems/multibody/multibody.hpp"

namespace conddp {

/// Length of the error of each contact that a system holds, in a state (nx numbers at least): m,
/// with angles of surfaces times 1 m.
std::vector<double> loop_gaps(const MultibodySystem& system, const std::vector<double>& x);

/// Joint positions with which these contacts have no error and bodies that float stay where they
/// are, as far as they differ from those of the state: "{knee: 0.8123, ankle: -0.2}". Empty if
/// Newton's method does not find any.
std::string closing_joints(const MultibodySystem& system, const std::vector<double>& x);

}  // namespace conddp
