#include "base/files/text_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <fcntl.h>

#include <fmt/format.h>

#include "base/files/check_sums.hpp"
#include "base/files/descriptor.hpp"
#include "base/text/utf8.hpp"

namespace conddp {
namespace {

/// Why a path is not a regular file.
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
  // Some kernel files are regular, but reading them would wait for the next event.
  const Descriptor descriptor(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (descriptor.get() < 0) return fail(fmt::format("cannot be opened: {}", std::strerror(errno)));
  std::string text;
  for (std::size_t size = 0;;) {
    if (size > limit) return fail(fmt::format("is larger than {} MiB", limit >> 20));
    std::error_code error;
    const std::uintmax_t whole = std::filesystem::file_size(file, error);
    constexpr std::size_t kLeast = 1 << 16;
    text.resize(std::max<std::size_t>(size + kLeast, error || whole > limit ? 0 : whole + 1));
    const ssize_t count = ::read(descriptor.get(), text.data() + size, text.size() - size);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return fail(fmt::format("cannot be read: {}", std::strerror(errno)));
    size += static_cast<std::size_t>(count);
    text.resize(size);
    if (count == 0) return {std::move(text), {}};
  }
}

std::optional<std::string> checked_text(std::string bytes, const std::string& name,
                                        Diagnostics& out) {
  std::string text = std::move(bytes);
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  const std::size_t bad = find_bad_character(text);
  if (bad == std::string::npos) return text;
  const TextPlace place = place_after(std::string_view(text).substr(0, bad));
  const int source = out.add_source(name, text.substr(0, bad));
  const bool foreign = static_cast<unsigned char>(text[bad]) >= 0x80;
  out.error({{source, place.line, place.column}, {}}, describe_bad_character(text, bad),
            foreign ? "save the file in UTF-8" : "");
  return std::nullopt;
}

std::optional<std::string> read_text(const std::filesystem::path& file, std::size_t limit,
                                     const Place& place, std::string& sha256, Diagnostics& out) {
  TextFile read = read_text_file(file, limit);
  if (!read.defect.empty()) {
    out.error(place, std::move(read.defect));
    return std::nullopt;
  }
  sha256 = conddp::sha256(read.text);
  return checked_text(std::move(read.text), file.string(), out);
}

}  // namespace conddp
