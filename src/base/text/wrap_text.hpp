#pragma once

#include <string>
#include <string_view>

namespace conddp {

/// Columns that UTF-8 text takes on a terminal: its characters, escape sequences for colours left
/// out.
int shown_width(std::string_view text);

/// Text broken at spaces into lines of at most `width` characters (0: one line; a longer word has a
/// line of its own), the first one indented by `first` and the others by `indent` spaces, each with
/// its end. Line ends of the text itself are kept.
std::string wrap_text(std::string_view text, int width, int first, int indent);

}  // namespace conddp
