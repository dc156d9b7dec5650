#include "systems/graphs/spline_table.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace conddp {
namespace {

void check_points(const std::vector<double>& points) {
  if (points.size() < 2 || points.size() > SplineTable::kMostPoints)
    throw std::invalid_argument("a table needs 2 to 10000 points in each argument");
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!std::isfinite(points[i]) || (i > 0 && points[i] <= points[i - 1]))
      throw std::invalid_argument("the points of a table have to be finite and ascending");
}

void check_values(const std::vector<double>& values) {
  for (const double value : values)
    if (!std::isfinite(value)) throw std::invalid_argument("the values of a table are finite");
}

/// Weights of the values at the points i and i + 1 and of the second derivatives there, in this
/// order. They describe a cubic piece, or the line beyond the ends.
struct Weights {
  int i;
  double of[4];
};

/// s(x) = A y₀ + B y₁ + h²/6 ((A³ − A) M₀ + (B³ − B) M₁) with B = (x − x₀)/h and A = 1 − B.
Weights weights_at(const std::vector<double>& points, double x, int order) {
  const int last = static_cast<int>(points.size()) - 1;
  const int above =
      static_cast<int>(std::upper_bound(points.begin(), points.end(), x) - points.begin());
  const int i = std::clamp(above - 1, 0, last - 1);
  const double h = points[i + 1] - points[i];
  const double inside = std::clamp(x, points.front(), points.back());
  const bool beyond = !(x == inside);  // true for NaN
  const double B = (inside - points[i]) / h, A = 1 - B;
  const double slope[] = {-1 / h, 1 / h, (1 - 3 * A * A) * h / 6, (3 * B * B - 1) * h / 6};
  Weights w{i, {0, 0, 0, 0}};
  switch (order) {
    case 0: {
      const double step = beyond ? x - inside : 0;
      const double value[] = {A, B, (A * A * A - A) * h * h / 6, (B * B * B - B) * h * h / 6};
      for (int k = 0; k < 4; ++k) w.of[k] = value[k] + step * slope[k];
      break;
    }
    case 1:
      std::copy_n(slope, 4, w.of);
      break;
    case 2:
      if (beyond) break;
      w.of[2] = A;
      w.of[3] = B;
      break;
    case 3:
      if (beyond) break;
      w.of[2] = -1 / h;
      w.of[3] = 1 / h;
      break;
    default:
      break;
  }
  return w;
}

}  // namespace

std::vector<double> natural_spline_curvatures(std::span<const double> points,
                                              std::span<const double> values) {
  const std::size_t n = points.size();
  std::vector<double> curvature(n, 0.0), factor(n, 0.0);
  // h₋/6 M₋ + (h₋ + h₊)/3 M + h₊/6 M₊ = slope₊ − slope₋, by elimination and back substitution.
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double before = points[i] - points[i - 1], after = points[i + 1] - points[i];
    const double bend = (values[i + 1] - values[i]) / after - (values[i] - values[i - 1]) / before;
    const double pivot = (before + after) / 3 - before / 6 * factor[i - 1];
    factor[i] = after / 6 / pivot;
    curvature[i] = (bend - before / 6 * curvature[i - 1]) / pivot;
  }
  for (std::size_t i = n - 1; i-- > 1;) curvature[i] -= factor[i] * curvature[i + 1];
  return curvature;
}

SplineTable::SplineTable(std::vector<double> x, std::vector<double> values) : x_(std::move(x)) {
  check_points(x_);
  if (values.size() != x_.size())
    throw std::invalid_argument("a table needs one value for each point");
  check_values(values);
  const std::vector<double> curvature = natural_spline_curvatures(x_, values);
  for (std::size_t i = 0; i < x_.size(); ++i) {
    nodes_.push_back(values[i]);
    nodes_.push_back(curvature[i]);
  }
}

SplineTable::SplineTable(std::vector<double> x, std::vector<double> y, std::vector<double> values)
    : x_(std::move(x)), y_(std::move(y)) {
  check_points(x_);
  check_points(y_);
  const std::size_t nx = x_.size(), ny = y_.size();
  if (values.size() != nx * ny)
    throw std::invalid_argument("a table needs one value for each pair of points");
  check_values(values);
  nodes_.assign(4 * nx * ny, 0.0);
  for (std::size_t k = 0; k < values.size(); ++k) nodes_[4 * k] = values[k];
  // The spline is linear in its values, so the second derivatives with respect to one argument are
  // splines in the other.
  const auto along = [&](const std::vector<double>& points, std::size_t first, std::size_t stride,
                         int from, int to) {
    std::vector<double> line(points.size());
    for (std::size_t i = 0; i < line.size(); ++i) line[i] = nodes_[4 * (first + i * stride) + from];
    const std::vector<double> curvature = natural_spline_curvatures(points, line);
    for (std::size_t i = 0; i < line.size(); ++i)
      nodes_[4 * (first + i * stride) + to] = curvature[i];
  };
  for (std::size_t j = 0; j < ny; ++j) along(x_, j, ny, 0, 1);
  for (std::size_t i = 0; i < nx; ++i) {
    along(y_, i * ny, 1, 0, 2);
    along(y_, i * ny, 1, 1, 3);
  }
}

double SplineTable::derivative(int by_x, int by_y, double x, double y) const {
  const Weights wx = weights_at(x_, x, by_x);
  double sum = 0;
  if (y_.empty()) {
    for (int k = 0; k < 2; ++k)
      for (int m = 0; m < 2; ++m) sum += wx.of[2 * m + k] * nodes_[2 * (wx.i + k) + m];
    return sum;
  }
  const Weights wy = weights_at(y_, y, by_y);
  for (int k = 0; k < 2; ++k)
    for (int l = 0; l < 2; ++l) {
      const double* node = &nodes_[4 * ((wx.i + k) * y_.size() + wy.i + l)];
      for (int m = 0; m < 2; ++m)
        sum += wx.of[2 * m + k] * (wy.of[l] * node[m] + wy.of[2 + l] * node[2 + m]);
    }
  return sum;
}

}  // namespace conddp
