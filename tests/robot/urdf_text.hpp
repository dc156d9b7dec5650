#pragma once

#include <string>

/// URDFs assembled from small pieces, one link or joint a line.
namespace conddp {

/// An inertia about axes that differ from the link's.
inline constexpr const char* kBody =
    R"(<inertial><origin xyz="0.1 0.02 -0.3" rpy="0.1 0.2 0.3"/><mass value="2"/>)"
    R"(<inertia ixx="0.05" ixy="0.001" ixz="0.002" iyy="0.06" iyz="0" izz="0.07"/></inertial>)";

inline std::string link_element(const std::string& name, const std::string& content = kBody) {
  return "<link name=\"" + name + "\">" + content + "</link>\n";
}
inline std::string joint_element(const std::string& name, const std::string& type,
                                 const std::string& parent, const std::string& child,
                                 const std::string& content = "") {
  return "<joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent +
         "\"/><child link=\"" + child + "\"/>" + content + "</joint>\n";
}
inline std::string robot_element(const std::string& content) {
  return "<robot name=\"r\">\n" + content + "</robot>\n";
}

}  // namespace conddp
