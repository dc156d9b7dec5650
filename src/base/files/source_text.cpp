#include "base/files/source_text.hpp"

#include "base/files/sha256.hpp"
#include "base/files/text_file.hpp"
#include "base/text/text_place.hpp"
#include "base/text/utf8.hpp"

namespace conddp {

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
