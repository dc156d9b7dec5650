#include "problem_file/time_series.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace conddp {

TimeSeries::TimeSeries(StateManifold manifold, std::vector<double> value)
    : manifold_(std::move(manifold)) {
  append(0, std::move(value));
}

void TimeSeries::append(double time, std::vector<double> value) {
  times_.push_back(time);
  values_.push_back(std::move(value));
}

std::vector<double> TimeSeries::interpolate(double time) const {
  const auto after = std::upper_bound(times_.begin(), times_.end(), time);
  if (after == times_.begin()) return values_.front();
  if (after == times_.end()) return values_.back();
  const std::size_t i = after - times_.begin();
  const double share = (time - times_[i - 1]) / (times_[i] - times_[i - 1]);
  std::vector<double> step(manifold_.ndx());
  manifold_.difference(values_[i - 1].data(), values_[i].data(), step.data());
  for (double& s : step) s *= share;
  std::vector<double> value(manifold_.nx());
  manifold_.integrate(values_[i - 1].data(), step.data(), value.data());
  return value;
}

const std::vector<double>& TimeSeries::hold(double time) const {
  const double tolerance = 1e-9 * std::max(1.0, std::abs(time));
  const auto after = std::upper_bound(times_.begin(), times_.end(), time + tolerance);
  return after == times_.begin() ? values_.front() : values_[after - times_.begin() - 1];
}

StateManifold rotation_manifold() {
  StateManifold manifold;
  manifold.append(StateManifold::Part::so3);
  return manifold;
}

StateManifold pose_manifold() {
  StateManifold manifold = StateManifold::flat(3);
  manifold.append(StateManifold::Part::so3);
  return manifold;
}

}  // namespace conddp
