#include "problem_file/data/height_map.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/files/check_sums.hpp"
#include "base/files/text_file.hpp"
#include "base/text/csv_line.hpp"
#include "base/text/strict_number.hpp"
#include "problem_file/data/gray_png.hpp"

namespace conddp {
namespace {

/// Heights and the number of heights along x.
struct Grid {
  std::vector<double> heights;
  int columns = 0;
};

/// The first line of a text, which is removed from it.
std::string_view take_line(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

Grid parse_csv_heights(const std::string& text, const std::string& name, Diagnostics& out) {
  const int source = out.add_source(name, text);
  Grid grid;
  std::string_view rest = text;
  for (int number = 1; !rest.empty(); ++number) {
    const std::string_view line = take_line(rest);
    if (trimmed_csv(line).empty()) continue;
    const auto fail = [&](int byte, std::string message, std::string hint = {}) {
      out.error({{source, number, out.character_column(source, number, byte)}, {}},
                std::move(message), std::move(hint));
      return Grid();
    };
    const std::vector<CsvCell> cells = split_csv_line(line);
    if (grid.columns == 0) grid.columns = static_cast<int>(cells.size());
    if (static_cast<int>(cells.size()) != grid.columns)
      return fail(
          0, fmt::format("this line has {} heights, the first one {}", cells.size(), grid.columns));
    for (const CsvCell& cell : cells) {
      const ParsedNumber height = parse_number(cell.text);
      if (!height.value)
        return fail(cell.byte, height.defect, "lines have heights alone, without a header");
      grid.heights.push_back(*height.value);
    }
  }
  return grid;
}

/// Reads the header of a PGM image: numbers between spaces and comments.
class PgmHeader {
 public:
  explicit PgmHeader(std::string_view text) : rest_(text) {}

  std::string_view word() {
    while (!rest_.empty() && (is_space(rest_.front()) || rest_.front() == '#'))
      rest_.front() == '#' ? void(take_line(rest_)) : rest_.remove_prefix(1);
    const auto end = std::ranges::find_if(rest_, is_space) - rest_.begin();
    const std::string_view word = rest_.substr(0, end);
    rest_.remove_prefix(end);
    return word;
  }
  int number() { return parse_count(word()).value_or(0); }
  std::string_view rest() const { return rest_; }

 private:
  static bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
  std::string_view rest_;
};

/// Values of pixels of one or two bytes each.
std::vector<double> gray_values(std::string_view pixels, std::size_t count, int bytes) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(pixels[i]); };
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i)
    values[i] = bytes == 1 ? byte(i) : 256 * byte(2 * i) + byte(2 * i + 1);
  return values;
}

Grid parse_png(std::string_view file, std::string& defect) {
  GrayImage image;
  defect = read_gray_png(file, image);
  if (!defect.empty()) return {};
  const std::size_t count = image.pixels.size() / image.bytes;
  return {gray_values(image.pixels, count, image.bytes), image.columns};
}

/// Gray values of a PGM image, of text (P2) or of one or two bytes each (P5).
Grid parse_pgm(std::string_view text, std::string& defect) {
  PgmHeader header(text);
  const std::string_view kind = header.word();
  const int columns = header.number(), rows = header.number(), white = header.number();
  constexpr int kLargest = 65535;
  defect = "it is not a PGM image (P2 or P5) of at most 16 bits";
  if ((kind != "P2" && kind != "P5") || white < 1 || white > kLargest) return {};
  const std::size_t count = static_cast<std::size_t>(columns) * rows, bytes = white > 255 ? 2 : 1;
  defect = "it has fewer gray values than its header says";
  Grid grid{{}, columns};
  if (count > text.size()) return {};
  if (kind == "P2") {
    for (std::size_t i = 0; i < count; ++i) {
      const auto value = parse_count(header.word());
      if (!value) return {};
      grid.heights.push_back(*value);
    }
  } else {
    const std::string_view pixels = header.rest().substr(std::min<std::size_t>(1, count));
    if (pixels.size() < count * bytes) return {};
    grid.heights = gray_values(pixels, count, static_cast<int>(bytes));
  }
  defect.clear();
  return grid;
}

/// The four numbers around an interval and its cubic convolution.
struct Cubic {
  double before, first, second, after;
  double value(double t) const {
    return first + t / 2 *
                       (second - before +
                        t * (2 * before - 5 * first + 4 * second - after +
                             t * (3 * (first - second) + after - before)));
  }
  double slope(double t) const {
    return (second - before) / 2 + t * (2 * before - 5 * first + 4 * second - after) +
           1.5 * t * t * (3 * (first - second) + after - before);
  }
};

/// A number of a row of n; one place beyond its ends, that of the parabola through the last three.
template <class At>
double extended(int i, int n, At at) {
  if (i < 0) return 3 * (at(0) - at(1)) + at(2);
  if (i >= n) return 3 * (at(n - 1) - at(n - 2)) + at(n - 3);
  return at(i);
}

template <class At>
Cubic around(int i, int n, At at) {
  return {extended(i - 1, n, at), extended(i, n, at), extended(i + 1, n, at),
          extended(i + 2, n, at)};
}

}  // namespace

void load_heights(const std::filesystem::path& folder, HeightMapSpec& map, Diagnostics& out) {
  const std::filesystem::path file = folder / map.file.value;
  const TextFile bytes = read_text_file(file, kMaxDataBytes);
  std::string defect = bytes.defect;
  Grid grid;
  const auto parse_image = file.extension() == ".pgm"   ? parse_pgm
                           : file.extension() == ".png" ? parse_png
                                                        : nullptr;
  if (defect.empty() && parse_image != nullptr) {
    grid = parse_image(bytes.text, defect);
  } else if (defect.empty()) {
    const int errors = out.error_count();
    if (const auto text = checked_text(bytes.text, file.string(), out))
      grid = parse_csv_heights(*text, file.string(), out);
    if (out.error_count() > errors) return;
  }
  constexpr int kFewest = 3;
  if (defect.empty() && (grid.columns < kFewest || grid.heights.size() / grid.columns < kFewest))
    defect = fmt::format("a height map has at least {0} by {0} heights", kFewest);
  if (!defect.empty())
    return out.error(
        map.file.place,
        bytes.defect.empty() ? fmt::format("'{}': {}", map.file.value, defect) : defect,
        "accepted: a CSV file of heights, line by line, and a gray PGM or PNG image");
  out.add_data_file({file.string(), sha256(bytes.text)});
  for (double& height : grid.heights) height *= map.scale;
  map.columns = grid.columns;
  map.heights = std::move(grid.heights);
}

std::optional<std::array<double, 3>> height_on(const HeightMapSpec& map, double x, double y) {
  const double u = (x - map.origin.x) / map.cell, v = (y - map.origin.y) / map.cell;
  const int columns = map.columns, rows = map.rows();
  if (!(u >= 0 && v >= 0 && u <= columns - 1 && v <= rows - 1)) return std::nullopt;
  const int i = std::min(static_cast<int>(u), columns - 2);
  const int j = std::min(static_cast<int>(v), rows - 2);
  const auto row = [&](int r) {
    return around(i, columns, [&](int c) { return map.heights[r * columns + c]; });
  };
  const Cubic heights = around(j, rows, [&](int r) { return row(r).value(u - i); });
  const Cubic slopes = around(j, rows, [&](int r) { return row(r).slope(u - i); });
  return std::array{map.origin.z + heights.value(v - j), slopes.value(v - j) / map.cell,
                    heights.slope(v - j) / map.cell};
}

}  // namespace conddp
