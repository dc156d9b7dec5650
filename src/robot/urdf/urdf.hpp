#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "robot/urdf/urdf_types.hpp"

namespace conddp {

/// Reads a URDF. Bad input of any kind is an error in the result, never an exception.
///
/// Joints are ordered depth first and, below one link, by name (Pinocchio's order). Fixed and
/// locked joints are merged into the body that carries them. Every link and joint of the file,
/// merged or not, has a frame at its pose in the URDF. The model's own joint frames are rotated so
/// that the axis is +z. A continuous joint has an unwrapped angle without limits.
UrdfResult load_urdf(const std::filesystem::path& file, const UrdfOptions& options = {});

/// Parses a URDF from text. `file_name` appears only in messages about the file as a whole.
UrdfResult parse_urdf(std::string_view xml, const std::string& file_name,
                      const UrdfOptions& options = {});

}  // namespace conddp
