#include "base/text/text_place.hpp"

#include <algorithm>

#include "base/text/utf8.hpp"

namespace conddp {

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
