#pragma once

#include "robot/urdf/urdf_report.hpp"

namespace conddp {

inline constexpr int kMaxUrdfLinks = 10'000;

/// Checks a document's elements one by one: root element, leftover xacro, names, duplicates,
/// numbers, misspelled elements and attributes, number of links. Removes all that is not read, so
/// that visuals and plug-ins neither fail in urdfdom nor reach its messages, which it uses as
/// printf formats. Returns false if the document is not an evaluated URDF with at most
/// `kMaxUrdfLinks` links; further checks are then pointless.
bool check_urdf_elements(pugi::xml_node robot, UrdfReport& report);

/// Checks that links and joints form one tree: names are present and unique, parents and children
/// exist, no loop, no link with two parents, one root. Mimic joints must refer to other joints
/// without a cycle, unless they are independent. urdfdom accepts violations of every rule in some
/// form, so this check runs before urdfdom does.
void check_urdf_topology(pugi::xml_node robot, const UrdfOptions& options, UrdfReport& report);

}  // namespace conddp
