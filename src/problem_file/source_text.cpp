#include "problem_file/source_text.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include <fmt/format.h>

#include "problem_file/sha256.hpp"
#include "robot/utf8.hpp"

namespace conddp {
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
    const int source = out.add_source(name, text.substr(0, bad));
    const int column = out.character_column(source, line, static_cast<int>(bad - line_start));
    const bool foreign = static_cast<unsigned char>(text[bad]) >= 0x80;
    out.error({{source, line, column}, {}}, describe_bad_character(text, bad),
              foreign ? "save the file in UTF-8" : "");
    return std::nullopt;
  }
  return text;
}

}  // namespace conddp
