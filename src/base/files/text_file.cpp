#include "base/files/text_file.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>

#include <fmt/format.h>

namespace conddp {

namespace {

/// What keeps a path from being a regular file.
std::string defect_of_path(const std::filesystem::path& file) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (std::filesystem::is_directory(status)) return "is a folder";
  if (std::filesystem::is_regular_file(status)) return {};
  if (std::filesystem::exists(status)) return "is not a regular file";
  if (error && error != std::errc::no_such_file_or_directory)
    return "cannot be opened: " + error.message();
  return "does not exist";
}

}  // namespace

TextFile read_text_file(const std::filesystem::path& file, std::size_t limit) {
  const auto fail = [&](const std::string& what) {
    return TextFile{{}, fmt::format("'{}' {}", file.string(), what)};
  };
  if (const std::string defect = defect_of_path(file); !defect.empty()) return fail(defect);
  std::error_code error;
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  if (!stream)
    return fail(
        fmt::format("cannot be opened: {}", errno != 0 ? std::strerror(errno) : "unknown cause"));
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  const std::string too_large = fmt::format("is larger than {} MiB", limit >> 20);
  if (!error && size > limit) return fail(too_large);
  std::string text(static_cast<std::size_t>(error ? limit : size) + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad()) return fail("cannot be read");
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (text.size() > limit) return fail(too_large);
  return {std::move(text), {}};
}

}  // namespace conddp
