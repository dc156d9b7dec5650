#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "base/text/diagnostic.hpp"

namespace conddp {

/// Size limits of inputs, bytes: far above any real file, low enough that reading stays quick.
inline constexpr std::size_t kMaxYamlBytes = 2 << 20;
inline constexpr std::size_t kMaxDataBytes = 64 << 20;

/// Reads a text file whole: it must be a regular file, no larger than the limit, valid UTF-8, and
/// free of control characters. A byte-order mark is dropped. Otherwise an error is reported at
/// `place`, or in the file itself where it is about the contents.
/// `sha256` receives the SHA-256 of the bytes that were read.
std::optional<std::string> read_text(const std::filesystem::path& file, std::size_t limit,
                                     const Place& place, std::string& sha256, Diagnostics& out);

/// The bytes of a text without a byte-order mark; nothing with an error in the text of this name
/// where they are not valid UTF-8 or have control characters.
std::optional<std::string> checked_text(std::string bytes, const std::string& name,
                                        Diagnostics& out);

}  // namespace conddp
