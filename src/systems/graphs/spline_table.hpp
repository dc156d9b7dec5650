#pragma once

#include <span>
#include <vector>

#include "spatial/dual.hpp"

namespace conddp {

/// Tabulated data as a function of one or two arguments: a natural cubic spline through the values,
/// or the tensor product of two. Twice continuously differentiable; linear beyond the first and the
/// last point of an argument.
class SplineTable {
 public:
  /// The largest number of grid points per argument.
  static constexpr int kMostPoints = 10000;

  /// One argument: at least two points, strictly ascending, and a value for each. Throws
  /// std::invalid_argument otherwise, or if a number is not finite.
  SplineTable(std::vector<double> x, std::vector<double> values);
  /// Two arguments; values[i * y.size() + j] belongs to (x[i], y[j]).
  SplineTable(std::vector<double> x, std::vector<double> y, std::vector<double> values);

  int arguments() const { return y_.empty() ? 1 : 2; }
  /// First and last grid point of an argument (0 or 1).
  double first(int argument) const { return (argument == 0 ? x_ : y_).front(); }
  double last(int argument) const { return (argument == 0 ? x_ : y_).back(); }

  /// The derivative of order `by_x` in the first argument and `by_y` in the second; with one
  /// argument, `y` and `by_y` are ignored.
  double derivative(int by_x, int by_y, double x, double y) const;

 private:
  std::vector<double> x_, y_;  ///< grid points; y is empty for one argument
  /// The numbers at each grid point in order: the value and the second derivative by x. With two
  /// arguments also the second derivative by y and the fourth mixed one; the order is value, x, y,
  /// both.
  std::vector<double> nodes_;
};

/// Second derivatives of the natural cubic spline at its points.
std::vector<double> natural_spline_curvatures(std::span<const double> points,
                                              std::span<const double> values);

/// A table's derivative, for every scalar.
inline double table_value(const SplineTable& table, int by_x, int by_y, double x, double y) {
  return table.derivative(by_x, by_y, x, y);
}
inline Lane table_value(const SplineTable& table, int by_x, int by_y, Lane x, Lane y) {
  return lanewise([&](double a, double b) { return table.derivative(by_x, by_y, a, b); }, x, y);
}
template <class S>
Dual<S> table_value(const SplineTable& table, int by_x, int by_y, const Dual<S>& x,
                    const Dual<S>& y) {
  S d = table_value(table, by_x + 1, by_y, x.v, y.v) * x.d;
  if (table.arguments() == 2) d += table_value(table, by_x, by_y + 1, x.v, y.v) * y.d;
  return {table_value(table, by_x, by_y, x.v, y.v), d};
}

}  // namespace conddp
