#pragma once

#include <string>
#include <string_view>

namespace conddp {

/// Display width of UTF-8 text on a terminal: its characters, without color escape sequences.
int shown_width(std::string_view text);

/// Text wrapped at spaces into lines of at most `width` characters; 0 means no wrapping. A longer
/// word has its own line. The first line is indented by `first` spaces and the others by `indent`;
/// each has a line end. Line ends in the text are preserved.
std::string wrap_text(std::string_view text, int width, int first, int indent);

}  // namespace conddp
