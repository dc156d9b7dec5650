#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "robot/urdf/urdf_types.hpp"

namespace conddp {

/// Reads a URDF. Bad input of any kind is an error in the result, never an exception.
///
/// Joints stand depth first, a link's children in the order of their joints' names (Pinocchio's
/// order), fixed and locked joints merged into the body that carries them. Every link and joint of
/// the file has a frame, merged or not, placed as the URDF says; the model's own joint frames are
/// turned so that the axis is +z. A continuous joint is one unwrapped angle without limits.
UrdfResult load_urdf(const std::filesystem::path& file, const UrdfOptions& options = {});

/// The same from text. `file_name` is only for messages about the file as a whole.
UrdfResult parse_urdf(std::string_view xml, const std::string& file_name,
                      const UrdfOptions& options = {});

}  // namespace conddp
