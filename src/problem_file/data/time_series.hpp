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
  /// A series that is constant.
  TimeSeries(StateManifold manifold, std::vector<double> value);

  /// Times must not decrease. Where values have the same time, what they are of jumps.
  void append(double time, std::vector<double> value);
  bool empty() const { return times_.empty(); }
  double last_time() const { return times_.back(); }
  /// Of the values, ascending.
  const std::vector<double>& times() const { return times_; }

  /// Makes interpolate() a natural cubic spline through the values: on flat parts that with
  /// continuous second derivatives and none at the ends; on curved parts the same bends are added
  /// to the geodesics in tangent coordinates. To be called after the last append(); times must
  /// increase.
  void make_cubic();

  /// Along the shortest way between neighbours (geodesic on curved parts) or the spline; outside,
  /// the nearest end. Of several values at one time (within rounding), the last one but `earlier`,
  /// or the first of them.
  std::vector<double> interpolate(double time, int earlier = 0) const;
  /// The last value not later than `time` (within rounding), or the first one.
  const std::vector<double>& hold(double time) const;

 private:
  /// Between each value and the next one, two values at least.
  std::vector<std::vector<double>> mean_slopes() const;
  /// Which value interpolate() takes as it is; nothing where `time` has not several.
  std::optional<std::size_t> value_at_jump(double time, int earlier) const;

  StateManifold manifold_;
  std::vector<double> times_;
  std::vector<std::vector<double>> values_;
  std::vector<std::vector<double>> bends_;  ///< second derivatives at the values; empty: linear
};

/// Manifolds of references: a rotation (quaternion), and a pose whose position and rotation are
/// interpolated apart.
StateManifold rotation_manifold();
StateManifold pose_manifold();

}  // namespace conddp
