#pragma once

#include <span>
#include <vector>

namespace conddp {

/// A dense symmetric matrix of which the first unknowns, the candidates, may be eliminated: L D Lᵀ
/// with pivots of 1 × 1 and 2 × 2 (Duff, Reid: The multifrontal solution of indefinite sparse
/// symmetric linear equations, ACM TOMS 9, 1983). The lower triangle is stored.
class DenseFront {
 public:
  /// D: a pivot, and what couples it with the next one where both make up a pivot of 2 × 2, else 0.
  struct Pivot {
    double value, coupling;
  };

  /// A matrix of zeros. Nothing is allocated where an earlier one was as large.
  void reset(int candidates, int size);

  int size() const { return size_; }
  int candidates() const { return candidates_; }
  /// How many of the candidates are eliminated: they come first. The rest of the matrix is the
  /// Schur complement then.
  int pivots() const { return pivots_; }
  /// How many eigenvalues of D are negative.
  int negative() const { return negative_; }

  /// What the rows are called; they are reordered as candidates are eliminated.
  std::span<int> names() { return {names_.data(), static_cast<std::size_t>(size_)}; }
  std::span<const int> names() const { return {names_.data(), static_cast<std::size_t>(size_)}; }

  /// In the lower triangle: row ≥ column. Below the diagonal of an eliminated column: L.
  double& at(int row, int column) { return values_[index(row, column)]; }
  double at(int row, int column) const { return values_[index(row, column)]; }
  double* column(int column) { return &values_[index(0, column)]; }
  const double* column(int column) const { return &values_[index(0, column)]; }
  const Pivot& pivot(int column) const { return diagonal_[static_cast<std::size_t>(column)]; }

  /// Eliminates candidates until none is left whose pivot is `tolerance`, of (0, ½], of the other
  /// entries in its column: with such a pivot, entries of L are at most 1 / tolerance.
  void eliminate(double tolerance);

 private:
  /// The largest entry of a column beside the diagonal, and which candidate is coupled most.
  struct Column {
    double largest = 0;
    int partner = -1;
    double coupling = 0;
  };

  std::size_t index(int row, int column) const {
    return static_cast<std::size_t>(column) * static_cast<std::size_t>(size_) +
           static_cast<std::size_t>(row);
  }
  double entry(int i, int j) const { return i >= j ? at(i, j) : at(j, i); }
  Column look_at(int column) const;
  double largest_beside(int column, int other) const;
  bool find_pivot(double tolerance);
  bool is_stable_pair(int column, int partner, double tolerance) const;
  void swap(int a, int b);
  void eliminate_one();
  void eliminate_pair();
  void update_rest();

  int candidates_ = 0, size_ = 0, pivots_ = 0, negative_ = 0;
  std::vector<double> values_, products_;
  std::vector<Pivot> diagonal_;
  std::vector<int> names_;
};

}  // namespace conddp
