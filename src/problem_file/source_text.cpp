#include "problem_file/source_text.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include <fmt/format.h>

#include "problem_file/sha256.hpp"

namespace conddp {
namespace {

/// Bytes of the character that starts at `i`, 0 if it is none (overlong forms and surrogates too).
std::size_t character_length(std::string_view text, std::size_t i) {
  const auto byte = [&](std::size_t k) {
    return k < text.size() ? static_cast<unsigned char>(text[k]) : 0u;
  };
  const unsigned first = byte(i);
  if (first < 0x80)
    return first >= 0x20 && first != 0x7F ? 1 : std::strchr("\t\n\r", first) ? 1 : 0;
  const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : first >= 0xC2 ? 2 : 0;
  if (first > 0xF4 || length == 0) return 0;
  for (std::size_t k = 1; k < length; ++k)
    if ((byte(i + k) & 0xC0) != 0x80) return 0;
  const unsigned second = byte(i + 1);
  if ((first == 0xE0 && second < 0xA0) || (first == 0xED && second > 0x9F) ||
      (first == 0xF0 && second < 0x90) || (first == 0xF4 && second > 0x8F))
    return 0;
  return length;
}

}  // namespace

std::size_t find_bad_character(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    if (text[i] == '\0') return i;
    const std::size_t length = character_length(text, i);
    if (length == 0) return i;
    i += length;
  }
  return std::string_view::npos;
}

std::optional<std::string> read_text(const std::filesystem::path& file, std::size_t limit,
                                     const Place& place, std::string& sha256, Diagnostics& out) {
  const std::string name = file.string();
  const auto fail = [&](std::string message) {
    out.error(place, std::move(message));
    return std::nullopt;
  };
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) {
    if (error && error != std::errc::no_such_file_or_directory)
      return fail(fmt::format("'{}' cannot be opened: {}", name, error.message()));
    return fail(fmt::format("'{}' does not exist", name));
  }
  if (std::filesystem::is_directory(status)) return fail(fmt::format("'{}' is a folder", name));
  if (!std::filesystem::is_regular_file(status))
    return fail(fmt::format("'{}' is not a regular file", name));
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  if (!stream)
    return fail(fmt::format("'{}' cannot be opened: {}", name,
                            errno != 0 ? std::strerror(errno) : "unknown cause"));
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  const auto too_large = [&] {
    return fail(fmt::format("'{}' is larger than {} MiB", name, limit >> 20));
  };
  if (!error && size > limit) return too_large();
  std::string text(static_cast<std::size_t>(error ? limit : size) + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad()) return fail(fmt::format("'{}' cannot be read", name));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (text.size() > limit) return too_large();
  sha256 = conddp::sha256(text);
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  if (const std::size_t bad = find_bad_character(text); bad != std::string::npos) {
    const auto before = std::string_view(text).substr(0, bad);
    const std::size_t line_start = before.rfind('\n') + 1;  // npos + 1 is 0
    const int line = static_cast<int>(std::count(before.begin(), before.end(), '\n')) + 1;
    const unsigned code = static_cast<unsigned char>(text[bad]);
    const int source = out.add_source(name, text.substr(0, bad));
    const int column = out.character_column(source, line, static_cast<int>(bad - line_start));
    out.error({{source, line, column}, {}},
              code >= 0x80 ? fmt::format("the text is not UTF-8 (byte 0x{:02X})", code)
                           : fmt::format("a control character (0x{:02X}) in the text", code),
              code >= 0x80 ? "save the file in UTF-8" : "");
    return std::nullopt;
  }
  return text;
}

}  // namespace conddp
