#pragma once

#include <filesystem>

namespace conddp {

/// Waits until a file's contents, or a folder's names, are on the disk. False, with errno, where
/// that failed; what cannot be flushed, such as a pipe, is no failure.
bool sync_to_disk(const std::filesystem::path& path);

}  // namespace conddp
