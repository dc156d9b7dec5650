#pragma once

#include "robot/urdf/urdf_report.hpp"

namespace conddp {

/// Checks that links and joints form one tree: names are present and unique, parents and children
/// exist, no loop, no link with two parents, one root. Mimic joints must refer to other joints
/// without a cycle, unless they are independent. urdfdom accepts violations of every rule in some
/// form, so this check runs before urdfdom does.
void check_urdf_topology(pugi::xml_node robot, const UrdfOptions& options, UrdfReport& report);

}  // namespace conddp
