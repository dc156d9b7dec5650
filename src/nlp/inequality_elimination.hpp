#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "nlp/symmetric_factorization.hpp"

namespace conddp {

/// Eliminates inequalities and leaves the rest to another factorization. In interior-point systems,
/// each inequality has two unknowns: its slack, which is coupled only with its multiplier, and that
/// multiplier. An entry of -1 or 1 couples them, whatever their diagonal, so that they form a pivot
/// of two rows. After its elimination, only the variables of the inequality are coupled. Thousands
/// of inequalities at a knot then cost no more than the sums of their outer products. Large
/// diagonal entries of active inequalities swamp the Hessian; refinement is left to the
/// interior-point method.
class InequalityElimination final : public SymmetricFactorization {
 public:
  explicit InequalityElimination(std::unique_ptr<SymmetricFactorization> rest);
  /// Elimination in front of a ChainFactorization.
  static std::unique_ptr<SymmetricFactorization> make();

  void analyse(int size, int entries, const int* rows, const int* columns) override;
  Outcome factorize(const double* values, double pivot_tolerance) override;
  void solve(double* b) const override;
  int negative_eigenvalues() const override { return negative_; }

  /// Number of unknowns hidden from the other factorization.
  int eliminated() const { return 2 * static_cast<int>(pairs_.size()); }

 private:
  /// A slack and its multiplier; columns_[first, last) are the entries of the multiplier's row.
  struct Pair {
    int slack, multiplier, first, last;
    double inverse[3] = {};  ///< of the two rows, entries by Target::Kind
  };
  /// An entry of a multiplier's row: its index, and its column among the remaining unknowns.
  struct Column {
    int entry, left;
    double value = 0;
  };
  /// Destination of an entry: one of the three of a pair, a multiplier's row, or the rest.
  struct Target {
    enum Kind { slack = 0, coupling = 1, multiplier = 2, column, rest } kind;
    int index;  ///< of the pair, or of the entry in columns_ or in the rest
  };

  void find_pairs(int entries, const int* rows, const int* columns);
  void part_coupled_pairs(int entries, const int* rows, const int* columns);
  void place_entries(int entries, const int* rows, const int* columns);
  void place_products();
  bool invert(Pair& pair);

  std::unique_ptr<SymmetricFactorization> rest_;
  int size_ = 0, left_size_ = 0;
  std::vector<Pair> pairs_;
  std::vector<int> pair_of_, left_;  ///< by unknown: its pair, and its number among the remaining
                                     ///< unknowns; −1 for none
  std::vector<Column> columns_;
  std::vector<Target> targets_;  ///< by entry
  std::vector<int> rest_rows_, rest_columns_;
  std::vector<int> products_;  ///< by pair, for columns i >= j: entry of the rest
  std::vector<double> rest_values_;
  int negative_ = 0;
  mutable Eigen::VectorXd local_;
};

}  // namespace conddp
