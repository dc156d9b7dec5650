#pragma once

#include <string_view>

namespace conddp {

/// A position in a text, from 1; columns count characters.
struct TextPlace {
  int line = 1;
  int column = 1;
};

/// Position behind a piece of UTF-8 text that begins at `start`.
TextPlace place_after(std::string_view text, TextPlace start = {});

}  // namespace conddp
