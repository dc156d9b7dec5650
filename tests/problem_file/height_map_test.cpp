// Height maps against scipy (scripts/peers/height_fixtures.py) and analytic surfaces, and their
// files.
#include "problem_file/data/height_map.hpp"

#include <cstdint>
#include <fstream>

#include <png.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/source_tree.hpp"
#include "support/temporary_folder.hpp"

namespace conddp {
namespace {

HeightMapSpec quadratic(int rows, int columns) {
  HeightMapSpec map{.cell = 0.5, .origin = {-1, 2, 0.25}, .columns = columns};
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j) map.heights.push_back(0.3 * j * j - 0.2 * i * j + 0.1 * i);
  return map;
}

TEST(HeightMap, ReproducesQuadraticSurfacesEverywhere) {
  const HeightMapSpec map = quadratic(4, 5);
  for (const double x : {-1.0, -0.9, -0.3, 0.2, 0.99, 1.0})
    for (const double y : {2.0, 2.1, 2.8, 3.5}) {
      const auto at = height_on(map, x, y);
      ASSERT_TRUE(at);
      const double j = (x + 1) / 0.5, i = (y - 2) / 0.5;
      EXPECT_NEAR((*at)[0], 0.25 + 0.3 * j * j - 0.2 * i * j + 0.1 * i, 1e-12);
      EXPECT_NEAR((*at)[1], (0.6 * j - 0.2 * i) / 0.5, 1e-12);
      EXPECT_NEAR((*at)[2], (-0.2 * j + 0.1) / 0.5, 1e-12);
    }
}

TEST(HeightMap, IsEmptyOutside) {
  const HeightMapSpec map = quadratic(4, 5);
  for (const auto& [x, y] : {std::pair(-1.01, 3.0), {1.01, 3.0}, {0.0, 1.99}, {0.0, 3.51}})
    EXPECT_FALSE(height_on(map, x, y)) << x << ' ' << y;
}

TEST(HeightMap, AgreesWithScipy) {
  std::ifstream file(source_tree().string() + "/tests/problem_file/data/heights.json");
  const auto fixture = nlohmann::json::parse(file);
  HeightMapSpec map{.cell = fixture["cell"]};
  for (const auto& row : fixture["heights"]) {
    map.columns = static_cast<int>(row.size());
    for (const double height : row) map.heights.push_back(height);
  }
  for (const auto& sample : fixture["samples"]) {
    const auto at = height_on(map, sample[0], sample[1]);
    ASSERT_TRUE(at);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR((*at)[i], sample[2 + i].get<double>(), 1e-11);
  }
}

/// The map of a file with these bytes; defects are returned as text.
std::pair<HeightMapSpec, std::string> loaded(const std::string& name, const std::string& bytes) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / name, std::ios::binary) << bytes;
  HeightMapSpec map{.file = {name, {}}, .cell = 1, .scale = 0.5};
  Diagnostics out;
  load_heights(folder.path(), map, out);
  return {map, format_diagnostics(out, false)};
}

TEST(HeightMapFile, ReadsLinesOfNumbersAlongX) {
  const auto [map, said] = loaded("a.csv", "0, 1, 2, 3\n4, 5, 6, 7\n8, 9, 10, 11\n");
  EXPECT_EQ(said, "");
  EXPECT_EQ(map.columns, 4);
  EXPECT_EQ((*height_on(map, 1, 2))[0], 0.5 * 9);
}

TEST(HeightMapFile, ReadsImagesOfAllKinds) {
  const std::vector<double> expected = {0, 0.5, 1, 1.5, 2, 2.5, 3, 3.5, 127.5};
  const std::pair<const char*, std::string> files[] = {
      {"text.pgm", "P2 # a comment\n3 3\n255\n0 1 2 3 4 5 6 7 255\n"},
      {"bytes.pgm", std::string("P5\n3 3\n255\n") + std::string("\0\1\2\3\4\5\6\7\xff", 9)},
      {"words.pgm",
       std::string("P5 3 3 65535\n") + std::string("\0\0\0\1\0\2\0\3\0\4\0\5\0\6\0\7\0\xff", 18)}};
  for (const auto& [name, bytes] : files) {
    const auto [map, said] = loaded(name, bytes);
    EXPECT_EQ(said, "") << name;
    EXPECT_EQ(map.columns, 3) << name;
    EXPECT_EQ(map.heights, expected) << name;
  }
}

/// A PNG image of 3 by 3 pixels; `format` as for libpng's png_image.
template <class Value>
std::string png(const std::vector<Value>& pixels, int format, int size = 3) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = image.height = static_cast<png_uint_32>(size);
  image.format = static_cast<png_uint_32>(format);
  png_alloc_size_t bytes = 0;
  std::string file;
  EXPECT_TRUE(png_image_write_to_memory(&image, nullptr, &bytes, 0, pixels.data(), 0, nullptr));
  file.resize(bytes);
  EXPECT_TRUE(png_image_write_to_memory(&image, file.data(), &bytes, 0, pixels.data(), 0, nullptr));
  file.resize(bytes);
  return file;
}

const std::vector<std::uint8_t> kGrayBytes = {0, 1, 2, 3, 40, 5, 6, 200, 255};

TEST(HeightMapFile, PngHasTheHeightsOfItsPgm) {
  const std::string bytes(kGrayBytes.begin(), kGrayBytes.end());
  const auto [expected, pgm_said] = loaded("a.pgm", "P5 3 3 255\n" + bytes);
  const auto [map, said] = loaded("a.png", png(kGrayBytes, PNG_FORMAT_GRAY));
  EXPECT_EQ(said, "");
  EXPECT_EQ(map.columns, 3);
  EXPECT_EQ(map.heights, expected.heights);
  EXPECT_EQ(map.heights[7], 100);
}

TEST(HeightMapFile, PngOfSixteenBitsHasNoGamma) {
  const std::vector<std::uint16_t> values = {0, 1, 255, 256, 257, 1000, 40000, 65534, 65535};
  const auto [map, said] = loaded("a.png", png(values, PNG_FORMAT_LINEAR_Y));
  EXPECT_EQ(said, "");
  ASSERT_EQ(map.heights.size(), values.size());
  for (std::size_t i = 0; i < values.size(); ++i) EXPECT_EQ(map.heights[i], 0.5 * values[i]);
}

TEST(HeightMapFile, ColorsAndTransparencyAreNoHeights) {
  const std::vector<std::uint8_t> pixels(36, 100);
  for (const int format : {PNG_FORMAT_RGB, PNG_FORMAT_GA, PNG_FORMAT_RGBA}) {
    const auto [map, said] = loaded("a.png", png(pixels, format));
    EXPECT_NE(said.find("it is not a gray PNG image of 8 or 16 bits"), std::string::npos) << said;
  }
}

TEST(HeightMapFile, EveryDamageOfAPngIsAnError) {
  const std::string good = png(kGrayBytes, PNG_FORMAT_GRAY);
  for (std::size_t size = 0; size < good.size(); ++size) {
    const auto [map, said] = loaded("a.png", good.substr(0, size));
    EXPECT_NE(said.find("'a.png': it is damaged ("), std::string::npos) << size << said;
    EXPECT_TRUE(map.heights.empty()) << size;
  }
  const std::size_t data = good.find("IDAT");
  ASSERT_NE(data, std::string::npos);
  for (const std::size_t at : {std::size_t{1}, std::size_t{17}, data + 6}) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 0x55);
    EXPECT_NE(loaded("a.png", bad).second.find("it is damaged ("), std::string::npos) << at;
  }
}

TEST(HeightMapFile, SmallFilesOfHugeImagesAreErrors) {
  constexpr int kSize = 4097;
  const std::string file = png(std::vector<std::uint8_t>(kSize * kSize), PNG_FORMAT_GRAY, kSize);
  EXPECT_LT(file.size(), 100'000u);
  EXPECT_NE(loaded("a.png", file).second.find("more than 16777216 pixels"), std::string::npos);
}

TEST(HeightMapFile, ReportsDefects) {
  const std::tuple<const char*, const char*, const char*> cases[] = {
      {"a.csv", "1, 2, 3\n4, 5\n", "a.csv:2:1: error: this line has 2 heights, the first one 3"},
      {"a.csv", "1, 2, 3\n4, x, 5\n", "a.csv:2:4: error: 'x'"},
      {"a.csv", "1, 2\n3, 4\n5, 6\n", "at least 3 by 3 heights"},
      {"a.pgm", "P6 3 3 255\n", "it is not a PGM image"},
      {"a.pgm", "P2 3 3 70000\n", "it is not a PGM image"},
      {"a.pgm", "P5 2000000000 0 255\n", "at least 3 by 3 heights"},
      {"a.pgm", "P5 3 3 255\nab", "fewer gray values"},
      {"a.pgm", "P2 3 3 255\n1 2 3", "fewer gray values"}};
  for (const auto& [name, bytes, says] : cases) {
    const auto [map, said] = loaded(name, bytes);
    EXPECT_NE(said.find(says), std::string::npos) << said;
    EXPECT_TRUE(map.heights.empty());
  }
}

}  // namespace
}  // namespace conddp
