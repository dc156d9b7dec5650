#pragma once

#include <optional>

#include "problem_file/model/spec_terrain.hpp"

namespace conddp {

/// The ground on the vertical through a place.
struct Ground {
  double height = 0;                ///< m
  Vector3<double> normal{0, 0, 1};  ///< unit vector that points upward
};

/// The highest ground of all pieces; empty where there is none.
std::optional<Ground> ground_at(const TerrainSpec& terrain, double x, double y);
/// The height there, m; −∞ where there is no ground.
double ground_height(const TerrainSpec& terrain, const Vector3<double>& p);

}  // namespace conddp
