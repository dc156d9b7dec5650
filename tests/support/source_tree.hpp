#pragma once

#include <filesystem>

namespace conddp {

/// The folder of the tested sources. As a function, it stays out of the commands that compile
/// tests, and compiler caches serve all clones.
std::filesystem::path source_tree();

}  // namespace conddp
