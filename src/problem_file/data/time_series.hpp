#pragma once

#include <optional>
#include <vector>

#include "systems/state_manifold.hpp"

namespace conddp {

/// Points of a manifold over time.
class TimeSeries {
 public:
  TimeSeries() = default;
  explicit TimeSeries(StateManifold manifold) : manifold_(std::move(manifold)) {}
  /// A constant series.
  TimeSeries(StateManifold manifold, std::vector<double> value);

  /// Times must not decrease. Equal times denote a jump.
  void append(double time, std::vector<double> value);
  bool empty() const { return times_.empty(); }
  double last_time() const { return times_.back(); }
  /// Times of the values, ascending.
  const std::vector<double>& times() const { return times_; }

  /// Makes interpolate() a natural cubic spline through the values. On flat parts it has continuous
  /// second derivatives, which are zero at the ends. On curved parts the same bends are added to
  /// the geodesics in tangent coordinates. Call after the last append(); times must increase.
  void make_cubic();

  /// Interpolates along the shortest path between neighbours (geodesic on curved parts) or the
  /// spline; outside the range, the nearest end applies. With several values at one time (within
  /// rounding), returns the one `earlier` places before the last, or the first.
  std::vector<double> interpolate(double time, int earlier = 0) const;
  /// The last value not later than `time` (within rounding), or the first one.
  const std::vector<double>& hold(double time) const;

 private:
  /// Mean slopes between consecutive values; requires at least two values.
  std::vector<std::vector<double>> mean_slopes() const;
  /// Index of the value that interpolate() returns unchanged; empty if fewer than two values have
  /// this time.
  std::optional<std::size_t> value_at_jump(double time, int earlier) const;

  StateManifold manifold_;
  std::vector<double> times_;
  std::vector<std::vector<double>> values_;
  std::vector<std::vector<double>> bends_;  ///< second derivatives at the values; empty: linear
};

/// Manifolds of references: a rotation (quaternion), and a pose with separate interpolation of
/// position and rotation.
StateManifold rotation_manifold();
StateManifold pose_manifold();

}  // namespace conddp
