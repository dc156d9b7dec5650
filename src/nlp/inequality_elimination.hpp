#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "nlp/symmetric_factorization.hpp"

namespace conddp {

/// Eliminates inequalities, and leaves the rest to another factorization. In the systems of an
/// interior point each inequality has two unknowns: its slack, which nothing but its multiplier is
/// coupled with, and that multiplier. Whatever their diagonal, -1 or 1 couples them, so that they
/// are a pivot of two rows, after which only the variables of the inequality are coupled. Thousands
/// of inequalities at a knot then cost no more than the sums of their outer products. Large numbers
/// on the diagonal of active ones swamp the Hessian; it is for the interior point to refine.
class InequalityElimination final : public SymmetricFactorization {
 public:
  explicit InequalityElimination(std::unique_ptr<SymmetricFactorization> rest);
  /// In front of a ChainFactorization.
  static std::unique_ptr<SymmetricFactorization> make();

  void analyse(int size, int entries, const int* rows, const int* columns) override;
  Outcome factorize(const double* values, double pivot_tolerance) override;
  void solve(double* b) const override;
  int negative_eigenvalues() const override { return negative_; }

  /// How many unknowns the other factorization does not see.
  int eliminated() const { return 2 * static_cast<int>(pairs_.size()); }

 private:
  /// A slack and its multiplier; columns_[first, last) are the entries of the multiplier's row.
  struct Pair {
    int slack, multiplier, first, last;
    double inverse[3] = {};  ///< of the two rows: entries by Target::Kind
  };
  /// An entry of a multiplier's row: which, and its column among the unknowns that are left.
  struct Column {
    int entry, left;
    double value = 0;
  };
  /// Where an entry goes: to one of the three of a pair, to a multiplier's row, or to the rest.
  struct Target {
    enum Kind { slack = 0, coupling = 1, multiplier = 2, column, rest } kind;
    int index;  ///< of the pair, or of the entry of the rest
  };

  void find_pairs(int entries, const int* rows, const int* columns);
  void part_coupled_pairs(int entries, const int* rows, const int* columns);
  void place_entries(int entries, const int* rows, const int* columns);
  void place_products();
  bool invert(Pair& pair);

  std::unique_ptr<SymmetricFactorization> rest_;
  int size_ = 0, left_size_ = 0;
  std::vector<Pair> pairs_;
  std::vector<int> pair_of_, left_;  ///< by unknown: its pair, and its number among those left; -1
  std::vector<Column> columns_;
  std::vector<Target> targets_;  ///< by entry
  std::vector<int> rest_rows_, rest_columns_;
  std::vector<int> products_;  ///< by pair, of columns i >= j: which entry of the rest
  std::vector<double> rest_values_;
  int negative_ = 0;
  mutable Eigen::VectorXd local_;
};

}  // namespace conddp
