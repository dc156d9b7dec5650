#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace conddp {

/// Where a text stops being UTF-8 or has a control character other than tab and line ends: the
/// byte's index, or npos if it never does.
std::size_t find_bad_character(std::string_view text);

/// What is said of the byte at which `find_bad_character` stopped.
std::string describe_bad_character(std::string_view text, std::size_t at);

/// The text as it can be shown on one line of any terminal: control characters, line ends and what
/// is no UTF-8 written as escapes ("\n", "\x1B", "\u202E"), and cut off behind a good thousand
/// bytes. Control characters are those of ASCII and ISO 8859, the separators of lines and
/// paragraphs, and what turns the direction of writing.
std::string printable(std::string_view text);

/// A text of several lines likewise: line ends and tabs stay, and escapes are those of strings in
/// JSON and YAML ("\u001B"), so that a document with such a character remains the same document.
std::string terminal_text(std::string_view text);

/// The text with a '?' for each character that would be escaped, so that columns stay where they
/// are.
std::string masked(std::string_view text);

/// Whether a byte of UTF-8 text begins a character.
bool starts_character(char c);
/// Characters in UTF-8 text.
int count_characters(std::string_view text);

}  // namespace conddp
