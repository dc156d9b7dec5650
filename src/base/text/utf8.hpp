#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace conddp {

/// Index of the first byte that is not UTF-8 or begins a control character other than tab and line
/// ends; npos without one.
std::size_t find_bad_character(std::string_view text);

/// Describes the byte that `find_bad_character` returned.
std::string describe_bad_character(std::string_view text, std::size_t at);

/// The text in a form that any terminal shows on one line, truncated after a little more than a
/// thousand bytes. Control characters, line ends and invalid UTF-8 become escapes ("\n", "\x1B",
/// "\u202E"). Control characters are those of ASCII and ISO 8859, line and paragraph separators,
/// and characters that change the writing direction.
std::string printable(std::string_view text);

/// The same for a text of several lines: line ends and tabs stay. Escapes are those of JSON and
/// YAML strings ("\u001B"), so that a document with such a character keeps its meaning.
std::string terminal_text(std::string_view text);

/// The text with '?' for each character that would be escaped, which preserves columns.
std::string masked(std::string_view text);

/// True if a byte of UTF-8 text begins a character.
bool starts_character(char c);
/// Number of characters in UTF-8 text.
int count_characters(std::string_view text);

/// A position in a text, from 1; columns count characters.
struct TextPlace {
  int line = 1;
  int column = 1;
};

/// Position behind a piece of UTF-8 text that begins at `start`.
TextPlace place_after(std::string_view text, TextPlace start = {});

}  // namespace conddp
