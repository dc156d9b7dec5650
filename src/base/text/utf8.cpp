#include "base/text/utf8.hpp"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>

namespace conddp {
namespace {

bool is_control(unsigned byte) { return byte < 0x20 || byte == 0x7F; }

/// An inclusive range of numbers.
struct Range {
  unsigned first, last;
  bool contains(unsigned number) const { return first <= number && number <= last; }
};

/// Lead bytes of multi-byte characters. Continuation bytes are 0x80 to 0xBF, but the second byte
/// may have a smaller range. This excludes overlong forms, surrogates and code points beyond
/// Unicode (table 3-7 of the Unicode standard).
struct Lead {
  Range first;
  std::size_t length;
  Range second;
};
constexpr Lead kLeads[] = {
    {{0xC2, 0xDF}, 2, {0x80, 0xBF}}, {{0xE0, 0xE0}, 3, {0xA0, 0xBF}},
    {{0xE1, 0xEC}, 3, {0x80, 0xBF}}, {{0xED, 0xED}, 3, {0x80, 0x9F}},
    {{0xEE, 0xEF}, 3, {0x80, 0xBF}}, {{0xF0, 0xF0}, 4, {0x90, 0xBF}},
    {{0xF1, 0xF3}, 4, {0x80, 0xBF}}, {{0xF4, 0xF4}, 4, {0x80, 0x8F}},
};

/// Length in bytes of the character that starts at `i`; 0 if it is invalid.
std::size_t character_length(std::string_view text, std::size_t i) {
  const auto byte = [&](std::size_t k) {
    return k < text.size() ? static_cast<unsigned char>(text[k]) : 0u;
  };
  if (byte(i) < 0x80) return 1;
  const auto* lead = std::find_if(std::begin(kLeads), std::end(kLeads),
                                  [&](const Lead& l) { return l.first.contains(byte(i)); });
  if (lead == std::end(kLeads) || !lead->second.contains(byte(i + 1))) return 0;
  for (std::size_t k = 2; k < lead->length; ++k)
    if ((byte(i + k) & 0xC0) != 0x80) return 0;
  return lead->length;
}

/// True if a terminal interprets the character as a command, or displays subsequent text in another
/// position.
bool is_control_point(unsigned code) {
  constexpr Range kControls[] = {{0, 0x1F},        {0x7F, 0x9F},     {0x061C, 0x061C},
                                 {0x200E, 0x200F}, {0x2028, 0x202E}, {0x2066, 0x2069}};
  return std::any_of(std::begin(kControls), std::end(kControls),
                     [code](const Range& range) { return range.contains(code); });
}

struct Character {
  std::string_view bytes;
  unsigned code = 0;   ///< code point; the byte itself if it is not UTF-8
  bool valid = false;  ///< valid UTF-8
  bool shown = false;  ///< safe to display on any terminal
};

/// The character that starts at `i`, or a single byte if it is invalid.
Character character_at(std::string_view text, std::size_t i) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[i + k]); };
  const std::size_t length = character_length(text, i);
  if (length == 0) return {text.substr(i, 1), byte(0)};
  constexpr unsigned kFirstBits[] = {0, 0x7F, 0x1F, 0x0F, 0x07};
  unsigned code = byte(0) & kFirstBits[length];
  for (std::size_t k = 1; k < length; ++k) code = (code << 6) | (byte(k) & 0x3F);
  return {text.substr(i, length), code, true, !is_control_point(code)};
}

std::string printable(const Character& c) {
  switch (c.code) {
    case '\n':
      return "\\n";
    case '\t':
      return "\\t";
    case '\r':
      return "\\r";
    default:
      if (c.shown) return std::string(c.bytes);
      return c.bytes.size() == 1 ? fmt::format("\\x{:02X}", c.code)
                                 : fmt::format("\\u{:04X}", c.code);
  }
}

}  // namespace

std::size_t find_bad_character(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const unsigned byte = static_cast<unsigned char>(text[i]);
    if (byte >= ' ' && byte < 0x7f) {
      ++i;
      continue;
    }
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
    shown += printable(c);
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

TextPlace place_after(std::string_view text, TextPlace start) {
  if (const std::size_t end = text.rfind('\n'); end != text.npos) {
    start.line += static_cast<int>(std::count(text.begin(), text.end(), '\n'));
    start.column = 1;
    text.remove_prefix(end + 1);
  }
  start.column += count_characters(text);
  return start;
}

}  // namespace conddp
