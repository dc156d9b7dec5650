#pragma once

#include <string>
#include <string_view>

#include "robot/urdf/urdf_report.hpp"

namespace conddp {

inline constexpr std::size_t kMaxUrdfBytes = std::size_t{16} << 20;
inline constexpr int kMaxUrdfLinks = 10'000;

/// What can be said of a file before its XML is scanned: empty, too large, not UTF-8.
std::optional<UrdfProblem> check_urdf_text(std::string_view text, const std::string& file_name);

/// Checks a document's elements one by one: root element, xacro left over, names, duplicates,
/// numbers, misspelt elements and attributes, number of links. False: it is no URDF or far too
/// large, and nothing else need be said.
bool check_urdf_elements(const XmlOutline& outline, UrdfReport& report);

/// The document reduced to the elements from which a model is built, everything else replaced by
/// blanks. Visuals, materials, plug-ins and comments can then neither fail in the parser nor reach
/// its messages, which it uses as printf formats.
std::string relevant_urdf(const XmlOutline& outline, std::string_view text);

}  // namespace conddp
