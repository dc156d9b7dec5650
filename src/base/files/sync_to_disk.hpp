#pragma once

#include <filesystem>

namespace conddp {

/// Waits until a file's contents, or a folder's entries, are on disk. Returns false, with errno
/// set, on failure. Files that cannot be flushed, such as pipes, are not an error.
bool sync_to_disk(const std::filesystem::path& path);

}  // namespace conddp
