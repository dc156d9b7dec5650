#include "base/utf8.hpp"

#include <algorithm>

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

/// Whether a terminal takes it for a command, or shows what follows elsewhere than it stands.
bool is_control_point(unsigned code) {
  return code < 0x20 || (code >= 0x7F && code < 0xA0) || code == 0x061C || code == 0x200E ||
         code == 0x200F || (code >= 0x2028 && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069);
}

struct Character {
  std::string_view bytes;
  unsigned code = 0;   ///< its code point; the byte where it is no UTF-8
  bool valid = false;  ///< UTF-8
  bool shown = false;  ///< any terminal shows it as it stands
};

/// The character that starts at `i`, or the byte there.
Character character_at(std::string_view text, std::size_t i) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[i + k]); };
  const std::size_t length = character_length(text, i);
  if (length == 0) return {text.substr(i, 1), byte(0)};
  constexpr unsigned kFirstBits[] = {0, 0x7F, 0x1F, 0x0F, 0x07};
  unsigned code = byte(0) & kFirstBits[length];
  for (std::size_t k = 1; k < length; ++k) code = (code << 6) | (byte(k) & 0x3F);
  return {text.substr(i, length), code, true, !is_control_point(code)};
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
    const Character c = character_at(text, i);
    if (c.code == '\n' || c.code == '\t' || c.code == '\r')
      shown += c.code == '\n' ? "\\n" : c.code == '\t' ? "\\t" : "\\r";
    else if (c.shown)
      shown += c.bytes;
    else
      shown +=
          c.bytes.size() == 1 ? fmt::format("\\x{:02X}", c.code) : fmt::format("\\u{:04X}", c.code);
    i += c.bytes.size();
  }
  return shown;
}

std::string terminal_text(std::string_view text) {
  std::string shown;
  shown.reserve(text.size());
  for (std::size_t i = 0; i < text.size();) {
    const Character c = character_at(text, i);
    if (c.shown || c.code == '\n' || c.code == '\t')
      shown += c.bytes;
    else
      shown += c.valid ? fmt::format("\\u{:04X}", c.code) : fmt::format("\\x{:02X}", c.code);
    i += c.bytes.size();
  }
  return shown;
}

std::string masked(std::string_view text) {
  std::string shown;
  for (std::size_t i = 0; i < text.size();) {
    const Character c = character_at(text, i);
    if (c.shown)
      shown += c.bytes;
    else
      shown += '?';
    i += c.bytes.size();
  }
  return shown;
}

bool starts_character(char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }

int count_characters(std::string_view text) {
  return static_cast<int>(std::count_if(text.begin(), text.end(), starts_character));
}

}  // namespace conddp
