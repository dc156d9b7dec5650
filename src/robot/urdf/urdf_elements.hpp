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

}  // namespace conddp
