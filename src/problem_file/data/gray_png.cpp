#include "problem_file/data/gray_png.hpp"

#include <algorithm>
#include <csetjmp>
#include <vector>

#include <png.h>

#include <fmt/format.h>

namespace conddp {
namespace {

/// What libpng works on. It reports errors by longjmp, which would skip destructors: objects that
/// have some are here, outside of the frames that it leaves.
struct PngReading {
  std::string_view rest;
  std::string defect;
  GrayImage& image;
  std::vector<png_bytep> lines;
  png_structp png = nullptr;
  png_infop info = nullptr;

  PngReading(std::string_view file, GrayImage& read) : rest(file), image(read) {}
  ~PngReading() { png_destroy_read_struct(&png, &info, nullptr); }
  PngReading(const PngReading&) = delete;
  PngReading& operator=(const PngReading&) = delete;
};

extern "C" void keep_png_error(png_structp png, png_const_charp message) {
  static_cast<PngReading*>(png_get_error_ptr(png))->defect =
      fmt::format("it is damaged ({})", message);
  png_longjmp(png, 1);
}

extern "C" void ignore_png_warning(png_structp, png_const_charp) {}

extern "C" void take_png_bytes(png_structp png, png_bytep bytes, std::size_t count) {
  std::string_view& rest = static_cast<PngReading*>(png_get_io_ptr(png))->rest;
  if (rest.size() < count) png_error(png, "it ends too early");
  std::copy_n(rest.begin(), count, bytes);
  rest.remove_prefix(count);
}

/// Reads the header into the image; returns its defect.
std::string read_png_header(PngReading& reading) {
  png_read_info(reading.png, reading.info);
  const png_uint_32 columns = png_get_image_width(reading.png, reading.info);
  const png_uint_32 rows = png_get_image_height(reading.png, reading.info);
  const int bits = png_get_bit_depth(reading.png, reading.info);
  if (png_get_color_type(reading.png, reading.info) != PNG_COLOR_TYPE_GRAY || bits < 8)
    return "it is not a gray PNG image of 8 or 16 bits without transparency";
  if (static_cast<long>(columns) * rows > kMostPixels)
    return fmt::format("it has more than {} pixels", kMostPixels);
  reading.image = {static_cast<int>(columns), static_cast<int>(rows), bits / 8, {}};
  return {};
}

void read_png_lines(PngReading& reading) {
  GrayImage& image = reading.image;
  png_set_interlace_handling(reading.png);
  const std::size_t line = static_cast<std::size_t>(image.columns) * image.bytes;
  image.pixels.resize(line * image.rows);
  for (int row = 0; row < image.rows; ++row)
    reading.lines.push_back(reinterpret_cast<png_bytep>(image.pixels.data() + line * row));
  png_read_image(reading.png, reading.lines.data());
  png_read_end(reading.png, nullptr);
}

}  // namespace

std::string read_gray_png(std::string_view file, GrayImage& image) {
  PngReading reading(file, image);
  reading.png =
      png_create_read_struct(PNG_LIBPNG_VER_STRING, &reading, keep_png_error, ignore_png_warning);
  if (reading.png != nullptr) reading.info = png_create_info_struct(reading.png);
  if (reading.info == nullptr) return "libpng cannot read it";
  if (setjmp(png_jmpbuf(reading.png)) == 0) {
    png_set_read_fn(reading.png, &reading, take_png_bytes);
    reading.defect = read_png_header(reading);
    if (reading.defect.empty()) read_png_lines(reading);
  }
  return std::move(reading.defect);
}

}  // namespace conddp
