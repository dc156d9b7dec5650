#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace conddp {

/// What stands in a file, or why that is not known.
struct TextFile {
  std::string text;
  std::string defect;  ///< a sentence that names the file, empty if it was read
};

/// Reads a regular file of at most `limit` bytes. Folders, devices and pipes are not read, so that
/// nothing waits or goes on for ever.
TextFile read_text_file(const std::filesystem::path& file, std::size_t limit);

}  // namespace conddp
