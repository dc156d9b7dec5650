#pragma once

#include <span>
#include <vector>

namespace conddp {

/// A dense symmetric matrix with L D Lᵀ elimination of its first unknowns, the candidates, by
/// pivots of 1 × 1 and 2 × 2 (Duff, Reid: The multifrontal solution of indefinite sparse symmetric
/// linear equations, ACM TOMS 9, 1983). The lower triangle is stored.
class DenseFront {
 public:
  /// Entry of D: a pivot, and its coupling with the next one if both form a 2 × 2 pivot, else 0.
  struct Pivot {
    double value, coupling;
  };

  /// Becomes a matrix of zeros. Allocates nothing if an earlier matrix was as large.
  void reset(int candidates, int size);

  int size() const { return size_; }
  int candidates() const { return candidates_; }
  /// Number of eliminated candidates, which come first. The rest of the matrix is then the Schur
  /// complement.
  int pivots() const { return pivots_; }
  /// Number of negative eigenvalues of D.
  int negative() const { return negative_; }

  /// Names of the rows, reordered as candidates are eliminated.
  std::span<int> names() { return {names_.data(), static_cast<std::size_t>(size_)}; }
  std::span<const int> names() const { return {names_.data(), static_cast<std::size_t>(size_)}; }

  /// Entry of the lower triangle: row ≥ column. Below the diagonal of an eliminated column, this is
  /// L.
  double& at(int row, int column) { return values_[index(row, column)]; }
  double at(int row, int column) const { return values_[index(row, column)]; }
  double* column(int column) { return &values_[index(0, column)]; }
  const double* column(int column) const { return &values_[index(0, column)]; }
  const Pivot& pivot(int column) const { return diagonal_[static_cast<std::size_t>(column)]; }

  /// Eliminates candidates until no pivot reaches `tolerance`, in (0, ½], times the other entries
  /// in its column. With such pivots, entries of L are at most 1 / tolerance.
  void eliminate(double tolerance);

 private:
  /// Largest off-diagonal entry of a column, and the candidate with the strongest coupling.
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
