#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/text/diagnostic.hpp"

namespace conddp {

/// Files as they are, and of folders the files in them with this suffix, in alphabetical order;
/// what lies in folders further down is not looked at. A folder without any such file, one that
/// cannot be read, and a file that stands twice are errors.
std::vector<std::filesystem::path> input_files(const std::vector<std::string>& arguments,
                                               const std::string& suffix, Diagnostics& out);

}  // namespace conddp
