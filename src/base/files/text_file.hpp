#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "base/text/diagnostic.hpp"

namespace conddp {

/// The contents of a file, or the reason why it could not be read.
struct TextFile {
  std::string text;
  std::string defect;  ///< a sentence that names the file; empty on success
};

/// Reads a regular file of at most `limit` bytes. Folders, devices and pipes are rejected, because
/// reading them could block or never end.
TextFile read_text_file(const std::filesystem::path& file, std::size_t limit);

/// Size limits of inputs in bytes: far above any real file, low enough to keep reading fast.
inline constexpr std::size_t kMaxYamlBytes = 2 << 20;
inline constexpr std::size_t kMaxDataBytes = 64 << 20;

/// Reads a whole text file: it must be regular, no larger than the limit, valid UTF-8, and free of
/// control characters. A byte-order mark is removed. Errors are reported at `place`, or in the file
/// itself if they are about its contents. `sha256` receives the SHA-256 of the bytes that were
/// read.
std::optional<std::string> read_text(const std::filesystem::path& file, std::size_t limit,
                                     const Place& place, std::string& sha256, Diagnostics& out);

/// Returns the text without a byte-order mark. Returns nothing if the bytes are not valid UTF-8 or
/// contain control characters; the error refers to the text by `name`.
std::optional<std::string> checked_text(std::string bytes, const std::string& name,
                                        Diagnostics& out);

}  // namespace conddp
