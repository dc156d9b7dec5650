#include "nlp/dense_front.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Core>

namespace conddp {
namespace {

/// Smaller pivots are zero, for a matrix whose largest entries are near 1. Rounding may leave more
/// of a zero pivot: steps through it are inaccurate, and Ipopt checks for that.
constexpr double kZero = 1e-20;
/// Rounding of a zero determinant, relative to its products.
constexpr double kZeroDeterminant = 1e-14;

using Vector = Eigen::Map<Eigen::VectorXd>;

}  // namespace

void DenseFront::reset(int candidates, int size) {
  candidates_ = candidates;
  size_ = size;
  pivots_ = negative_ = 0;
  const auto n = static_cast<std::size_t>(size);
  if (values_.size() < n * n) values_.resize(n * n);
  std::fill_n(values_.begin(), n * n, 0.0);
  if (names_.size() < n) {
    names_.resize(n);
    diagonal_.resize(n);
  }
}

void DenseFront::eliminate(double tolerance) {
  while (pivots_ < candidates_ && find_pivot(tolerance)) continue;
  update_rest();
}

DenseFront::Column DenseFront::look_at(int column) const {
  Column found;
  const auto compare = [&](int row) {
    const double value = std::abs(entry(row, column));
    if (row < candidates_ && value > found.coupling) {
      found.coupling = value;
      found.partner = row;
    }
    found.largest = std::max(found.largest, value);
  };
  for (int row = pivots_; row < column; ++row) compare(row);
  for (int row = column + 1; row < candidates_; ++row) compare(row);
  const double* below = &values_[index(0, column)];
  for (int row = std::max(candidates_, column + 1); row < size_; ++row)
    found.largest = std::max(found.largest, std::abs(below[row]));
  return found;
}

double DenseFront::largest_beside(int column, int other) const {
  double largest = 0;
  for (int row = pivots_; row < size_; ++row)
    if (row != column && row != other) largest = std::max(largest, std::abs(entry(row, column)));
  return largest;
}

bool DenseFront::is_stable_pair(int column, int partner, double tolerance) const {
  const double a = at(column, column), b = entry(column, partner), c = at(partner, partner);
  const double determinant = std::abs(a * c - b * b);
  if (determinant <= kZeroDeterminant * (std::abs(a * c) + b * b)) return false;
  const double beside = largest_beside(column, partner);
  const double beside_partner = largest_beside(partner, column);
  const double limit = determinant / tolerance;
  return std::abs(c) * beside + std::abs(b) * beside_partner <= limit &&
         std::abs(b) * beside + std::abs(a) * beside_partner <= limit;
}

bool DenseFront::find_pivot(double tolerance) {
  for (int column = pivots_; column < candidates_; ++column) {
    const Column found = look_at(column);
    const double pivot = std::abs(at(column, column));
    if (pivot > kZero && pivot >= tolerance * found.largest) {
      swap(pivots_, column);
      eliminate_one();
      return true;
    }
    if (found.coupling > kZero && is_stable_pair(column, found.partner, tolerance)) {
      const int partner = found.partner == pivots_ ? column : found.partner;
      swap(pivots_, column);
      swap(pivots_ + 1, partner);
      eliminate_pair();
      return true;
    }
  }
  return false;
}

void DenseFront::swap(int a, int b) {
  if (a == b) return;
  std::swap(names_[static_cast<std::size_t>(a)], names_[static_cast<std::size_t>(b)]);
  for (int c = 0; c < a; ++c) std::swap(at(a, c), at(b, c));
  std::swap(at(a, a), at(b, b));
  for (int i = a + 1; i < b; ++i) std::swap(at(i, a), at(b, i));
  for (int i = b + 1; i < size_; ++i) std::swap(at(i, a), at(i, b));
}

void DenseFront::eliminate_one() {
  const int k = pivots_;
  const double pivot = at(k, k);
  const Vector column(&at(k, k), size_ - k);
  for (int j = k + 1; j < candidates_; ++j) {
    const double factor = at(j, k) / pivot;
    if (factor == 0) continue;
    Vector(&at(j, j), size_ - j) -= factor * column.tail(size_ - j);
  }
  Vector(&at(k, k) + 1, size_ - k - 1) /= pivot;
  diagonal_[static_cast<std::size_t>(k)] = {pivot, 0};
  negative_ += pivot < 0;
  pivots_ = k + 1;
}

void DenseFront::eliminate_pair() {
  const int k = pivots_, rest = size_ - k - 2;
  const double a = at(k, k), b = at(k + 1, k), c = at(k + 1, k + 1);
  const double determinant = a * c - b * b;
  Vector first(&at(k, k) + 2, rest), second(&at(k + 1, k + 1) + 1, rest);
  for (int j = k + 2; j < candidates_; ++j) {
    const double x = first[j - k - 2], y = second[j - k - 2];
    if (x == 0 && y == 0) continue;
    const double to_first = (c * x - b * y) / determinant;
    const double to_second = (a * y - b * x) / determinant;
    Vector(&at(j, j), size_ - j) -=
        to_first * first.tail(size_ - j) + to_second * second.tail(size_ - j);
  }
  for (int i = 0; i < rest; ++i) {
    const double x = first[i], y = second[i];
    first[i] = (c * x - b * y) / determinant;
    second[i] = (a * y - b * x) / determinant;
  }
  at(k + 1, k) = 0;
  diagonal_[static_cast<std::size_t>(k)] = {a, b};
  diagonal_[static_cast<std::size_t>(k) + 1] = {c, 0};
  negative_ += determinant < 0 ? 1 : (a < 0 ? 2 : 0);
  pivots_ = k + 2;
}

void DenseFront::update_rest() {
  const int rest = size_ - candidates_;
  if (rest == 0 || pivots_ == 0) return;
  products_.resize(std::max(products_.size(), static_cast<std::size_t>(rest * pivots_)));
  Eigen::Map<Eigen::MatrixXd> products(products_.data(), rest, pivots_);
  using Block = Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>>;
  const Block factors(&at(candidates_, 0), rest, pivots_, Eigen::OuterStride<>(size_));
  for (int k = 0; k < pivots_; ++k) {
    const Pivot& pivot = diagonal_[static_cast<std::size_t>(k)];
    products.col(k) = pivot.value * factors.col(k);
    if (pivot.coupling == 0) continue;
    const Pivot& next = diagonal_[static_cast<std::size_t>(k) + 1];
    products.col(k) += pivot.coupling * factors.col(k + 1);
    products.col(k + 1) = pivot.coupling * factors.col(k) + next.value * factors.col(k + 1);
    ++k;
  }
  Block schur(&at(candidates_, candidates_), rest, rest, Eigen::OuterStride<>(size_));
  schur.triangularView<Eigen::Lower>() -= products * factors.transpose();
}

}  // namespace conddp
