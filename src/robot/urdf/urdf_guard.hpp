#pragma once

#include <string>
#include <string_view>

#include "robot/urdf/urdf_report.hpp"

namespace conddp {

inline constexpr std::size_t kMaxUrdfBytes = std::size_t{16} << 20;
inline constexpr int kMaxUrdfLinks = 10'000;

/// Checks a file's text before its XML is scanned. Returns a problem if it is empty, too large, or
/// not UTF-8.
std::optional<UrdfProblem> check_urdf_text(std::string_view text, const std::string& file_name);

/// Checks a document's elements one by one: root element, leftover xacro, names, duplicates,
/// numbers, misspelled elements and attributes, number of links. Returns false if the document is
/// not an evaluated URDF with at most `kMaxUrdfLinks` links; further checks are then pointless.
bool check_urdf_elements(const XmlOutline& outline, UrdfReport& report);

/// Document reduced to the elements that define a model; blanks replace everything else. Visuals,
/// materials, plug-ins and comments then neither fail in the parser nor reach its messages, which
/// it uses as printf formats.
std::string relevant_urdf(const XmlOutline& outline, std::string_view text);

}  // namespace conddp
