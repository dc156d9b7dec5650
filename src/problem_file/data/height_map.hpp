#pragma once

#include <array>
#include <optional>

#include "problem_file/model/spec_terrain.hpp"

namespace conddp {

/// Reads the heights of `map.file` from a CSV file (lines of numbers) or a PGM or PNG image (gray
/// values) in the problem file's folder. The first line is at the origin's y, further lines follow
/// along y; numbers follow along x. Defects are reported in a CSV file, or at the file's name.
void load_heights(const std::filesystem::path& folder, HeightMapSpec& map, Diagnostics& out);

/// Height (m) of a map and its derivatives along x and y; empty outside of the map. Bicubic
/// convolution interpolates: it is continuously differentiable, depends on the 16 nearest numbers
/// and reproduces quadratic surfaces (Keys, "Cubic convolution interpolation for digital image
/// processing", 1981).
std::optional<std::array<double, 3>> height_on(const HeightMapSpec& map, double x, double y);

}  // namespace conddp
