#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace conddp {

/// The contents of a file, or the reason why it could not be read.
struct TextFile {
  std::string text;
  std::string defect;  ///< a sentence that names the file; empty on success
};

/// Reads a regular file of at most `limit` bytes. Folders, devices and pipes are rejected, because
/// reading them could block or never end.
TextFile read_text_file(const std::filesystem::path& file, std::size_t limit);

}  // namespace conddp
