#pragma once

#include <filesystem>

namespace conddp {

/// The folder of the tested sources. A function, so that the folder is no part of the commands that
/// compile tests, and compiler caches serve all clones.
std::filesystem::path source_tree();

}  // namespace conddp
