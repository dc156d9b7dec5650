#pragma once

#include <filesystem>
#include <string>

namespace conddp {

/// The folder with example problems and schemas, relative to the tool: an installation may be
/// moved.
std::filesystem::path installed_data();

/// The package from which the tool was installed ("Debian package", "archive"), or "built from
/// source".
std::string installed_package();

}  // namespace conddp
