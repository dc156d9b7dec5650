#pragma once

#include <string_view>

#include "problem_file/motion/footholds.hpp"

namespace conddp {

/// Path of a foot from one foothold to the next. At the share s of its duration it has covered
/// s² (3 − 2 s) of the straight line, is 16·height·s² (1 − s)² above it, and turns and tilts
/// likewise.
struct SwingArc {
  const Foothold &first, &from, &to;  ///< first: in the initial state
  double height;                      ///< m
  Quaternion<double> stance;          ///< the frame's orientation in the initial state

  Vector3<double> place(double s) const;
  Quaternion<double> orientation(double s) const;
};

/// Height of an arc with which, in the middle half of its duration, all contact points are as far
/// above the terrain as those of `arc` are above level ground, m.
double clearing_height(const SwingArc& arc, const std::vector<Vector3<double>>& points,
                       const TerrainSpec& terrain);

/// A foot's step for warnings.
struct NamedStep {
  std::string_view foot;
  std::size_t number;  ///< from 1
  const Place& place;
};

/// Warns of an arc that passes through the terrain, and of a foothold on an edge.
void warn_of_terrain(const SwingArc& arc, const std::vector<Vector3<double>>& points,
                     const TerrainSpec& terrain, const NamedStep& step, Diagnostics& out);

}  // namespace conddp
