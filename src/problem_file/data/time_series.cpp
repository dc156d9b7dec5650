#include "problem_file/data/time_series.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "problem_file/data/data_table.hpp"

namespace conddp {

TimeSeries::TimeSeries(StateManifold manifold, std::vector<double> value)
    : manifold_(std::move(manifold)) {
  append(0, std::move(value));
}

void TimeSeries::append(double time, std::vector<double> value) {
  times_.push_back(time);
  values_.push_back(std::move(value));
}

std::vector<std::vector<double>> TimeSeries::mean_slopes() const {
  const std::size_t n = times_.size();
  std::vector<std::vector<double>> slopes(n - 1, std::vector<double>(manifold_.ndx()));
  for (std::size_t i = 0; i + 1 < n; ++i) {
    manifold_.difference(values_[i].data(), values_[i + 1].data(), slopes[i].data());
    for (double& slope : slopes[i]) slope /= times_[i + 1] - times_[i];
  }
  return slopes;
}

void TimeSeries::make_cubic() {
  const std::size_t n = times_.size(), rows = manifold_.ndx();
  bends_.assign(n, std::vector<double>(rows, 0.0));
  if (n < 3) return;
  const std::vector<std::vector<double>> slopes = mean_slopes();
  // Continuity of the first derivatives gives a tridiagonal system, solved by elimination.
  std::vector<double> pivots(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double before = times_[i] - times_[i - 1], after = times_[i + 1] - times_[i];
    const double factor = i > 1 ? before / pivots[i - 1] : 0.0;
    pivots[i] = 2 * (before + after) - factor * before;
    for (std::size_t r = 0; r < rows; ++r)
      bends_[i][r] = 6 * (slopes[i][r] - slopes[i - 1][r]) - factor * bends_[i - 1][r];
  }
  for (std::size_t i = n - 2; i > 0; --i)
    for (std::size_t r = 0; r < rows; ++r)
      bends_[i][r] = (bends_[i][r] - (times_[i + 1] - times_[i]) * bends_[i + 1][r]) / pivots[i];
}

std::optional<std::size_t> TimeSeries::value_at_jump(double time, int earlier) const {
  // The tolerance is relative, because steps may be short. At zero nothing is rounded, and values
  // of a table with increasing times differ by at least the minimum step.
  constexpr double kMostSteps = 1e6;
  const double tolerance = 1e-9 * std::abs(time) + kMostSteps * kLeastTimeStep;
  const auto first = std::lower_bound(times_.begin(), times_.end(), time - tolerance);
  const auto end = std::upper_bound(first, times_.end(), time + tolerance);
  const auto count = end - first;
  if (count < 2) return std::nullopt;
  return static_cast<std::size_t>(first - times_.begin() +
                                  std::max<std::ptrdiff_t>(count - 1 - earlier, 0));
}

std::vector<double> TimeSeries::interpolate(double time, int earlier) const {
  if (const auto at = value_at_jump(time, earlier)) return values_[*at];
  const auto after = std::upper_bound(times_.begin(), times_.end(), time);
  if (after == times_.begin()) return values_.front();
  if (after == times_.end()) return values_.back();
  const std::size_t i = after - times_.begin();
  const double share = (time - times_[i - 1]) / (times_[i] - times_[i - 1]);
  std::vector<double> step(manifold_.ndx());
  manifold_.difference(values_[i - 1].data(), values_[i].data(), step.data());
  for (double& s : step) s *= share;
  const double width = times_[i] - times_[i - 1], rest = 1 - share;
  for (std::size_t r = 0; r < step.size() && !bends_.empty(); ++r)
    step[r] += width * width / 6 *
               ((rest * rest * rest - rest) * bends_[i - 1][r] +
                (share * share * share - share) * bends_[i][r]);
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
