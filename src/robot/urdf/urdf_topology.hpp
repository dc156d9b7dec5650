#pragma once

#include "robot/urdf/urdf_report.hpp"

namespace conddp {

/// Checks that links and joints form one tree: names present and unique, parents and children
/// there, no loop, no link with two parents, one root, every link reached; and that mimic joints
/// refer to other joints without a cycle. urdfdom accepts all of the opposite in some form, so
/// this runs on the outline, before it.
void check_urdf_topology(const XmlOutline& outline, const UrdfOptions& options, UrdfReport& report);

}  // namespace conddp
