#pragma once

#include <filesystem>
#include <variant>

#include "problem_file/model/spec_collision.hpp"

namespace conddp {

/// Heights over a regular grid in the plane.
struct HeightMapSpec {
  Name file;        ///< as written in the problem file
  double cell = 0;  ///< distance of neighbouring numbers along x and y, m
  Vector3<double> origin = Vector3<double>::zero();  ///< where the first number has height 0, m
  double scale = 1;                                  ///< m in the unit of the file
  int columns = 0;                                   ///< along x
  std::vector<double> heights;  ///< m above the origin, rows along y one after the other

  int rows() const { return columns == 0 ? 0 : static_cast<int>(heights.size()) / columns; }
};

/// A piece of the ground that feet walk on. The ground is the highest of all pieces.
struct TerrainPieceSpec {
  Name name;
  std::variant<BoxSpec, HalfSpaceSpec, HeightMapSpec> form;
};

using TerrainSpec = std::vector<TerrainPieceSpec>;

}  // namespace conddp
