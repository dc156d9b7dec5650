#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/text/diagnostic.hpp"

namespace conddp {

/// Files as given, and for folders their files with this suffix in alphabetical order; subfolders
/// are not searched. Folders without such files, unreadable folders, and duplicate files are
/// errors.
std::vector<std::filesystem::path> input_files(const std::vector<std::string>& arguments,
                                               const std::string& suffix, Diagnostics& out);

}  // namespace conddp
