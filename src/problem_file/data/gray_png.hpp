#pragma once

#include <string>
#include <string_view>

namespace conddp {

/// A gray image, line by line from its top.
struct GrayImage {
  int columns = 0, rows = 0;
  int bytes = 1;       ///< of a pixel, most significant first
  std::string pixels;  ///< as in the file, without gamma
};

/// The most pixels of an image: files of some kilobytes may have billions.
inline constexpr long kMostPixels = 1 << 24;

/// Reads a PNG image of 8 or 16 bits, without color and transparency. Returns its defect, a clause;
/// empty on success.
std::string read_gray_png(std::string_view file, GrayImage& image);

}  // namespace conddp
