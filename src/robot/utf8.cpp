#include "robot/utf8.hpp"

#include <fmt/format.h>

namespace conddp {
namespace {

bool is_control(unsigned byte) { return byte < 0x20 || byte == 0x7F; }

/// Bytes of the character that starts at `i`, 0 if it is none (overlong forms and surrogates too).
std::size_t character_length(std::string_view text, std::size_t i) {
  const auto byte = [&](std::size_t k) {
    return k < text.size() ? static_cast<unsigned char>(text[k]) : 0u;
  };
  const unsigned first = byte(i);
  if (first < 0x80) return 1;
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
    const unsigned byte = static_cast<unsigned char>(text[i]);
    if (is_control(byte) && byte != '\t' && byte != '\n' && byte != '\r') return i;
    const std::size_t length = character_length(text, i);
    if (length == 0) return i;
    i += length;
  }
  return std::string_view::npos;
}

std::string describe_bad_character(std::string_view text, std::size_t at) {
  const unsigned byte = static_cast<unsigned char>(text[at]);
  return byte >= 0x80 ? fmt::format("the text is not UTF-8 (byte 0x{:02X})", byte)
                      : fmt::format("a control character (0x{:02X}) in the text", byte);
}

std::string printable(std::string_view text) {
  constexpr std::size_t kLongest = 1000;
  std::string shown;
  for (std::size_t i = 0; i < text.size();) {
    if (shown.size() > kLongest) return shown + "...";
    const unsigned byte = static_cast<unsigned char>(text[i]);
    const std::size_t length = character_length(text, i);
    if (byte == '\n' || byte == '\t' || byte == '\r')
      shown += byte == '\n' ? "\\n" : byte == '\t' ? "\\t" : "\\r";
    else if (is_control(byte) || length == 0)
      shown += fmt::format("\\x{:02X}", byte);
    else
      shown += text.substr(i, length);
    i += length == 0 ? 1 : length;
  }
  return shown;
}

}  // namespace conddp
