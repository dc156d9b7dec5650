#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "nlp/dense_front.hpp"
#include "nlp/symmetric_factorization.hpp"

namespace conddp {

/// Groups of the unknowns of a sparse symmetric system. Each group is coupled only with itself and
/// its neighbors, so the matrix is block tridiagonal. Groups are the levels of a breadth-first
/// search (George, Liu: Computer Solution of Large Sparse Positive Definite Systems, 1981). For a
/// horizon, they follow its knots, whatever the order of the unknowns.
struct Chain {
  std::vector<std::vector<int>> groups;
  std::vector<bool> goes_on;  ///< by group: true if the next group is coupled with it

  Chain() = default;
  /// Chain of a matrix with these entries in one triangle, or in both.
  Chain(int size, int entries, const int* rows, const int* columns);

  /// Number of unknowns in the front of a group: its own and those of the next coupled group.
  int front_size(std::size_t group) const;
};

/// L D Lᵀ of a matrix that is a chain of groups, computed by a dense front that passes along the
/// chain. The front holds a group and the next one, eliminates the first as far as pivots are large
/// enough, and hands on the rest. Powers of 2 first scale the matrix so that the largest entry of
/// each row is near 1 (Ruiz: A scaling algorithm to equilibrate both rows and columns norms in
/// matrices, 2001).
///
/// If a front hands on more unknowns than a group has, rows along the chain are nearly dependent.
/// The matrix then counts as singular, since growing fronts would cost the cube of the horizon.
/// Factorizations of one structure share their memory.
class ChainFactorization final : public SymmetricFactorization {
 public:
  static std::unique_ptr<SymmetricFactorization> make();

  void analyse(int size, int entries, const int* rows, const int* columns) override;
  Outcome factorize(const double* values, double pivot_tolerance) override;
  void solve(double* b) const override;
  int negative_eigenvalues() const override { return negative_; }

 private:
  /// A matrix entry: its index, and its position in the front of its group.
  struct Entry {
    int index, row, column;
  };
  /// Eliminated part of a front: `pivots` columns of L, each `size` long, and D.
  struct Factor {
    int size, pivots;
    std::size_t columns, pivot, names;  ///< offsets in columns_, diagonal_, names_
  };

  void place_entries();
  void find_scale(const double* values);
  void hand_on(const DenseFront& from, DenseFront& to, std::size_t group);
  void keep(const DenseFront& front);
  void divide(const Factor& factor) const;

  int size_ = 0, most_left_ = 0;
  Chain chain_;
  std::vector<int> rows_, columns_of_;       ///< by entry
  std::vector<std::vector<Entry>> entries_;  ///< by group
  Eigen::VectorXd scale_, largest_;          ///< by unknown
  DenseFront fronts_[2];

  std::vector<Factor> factors_;
  std::vector<double> columns_;
  std::vector<DenseFront::Pivot> diagonal_;
  std::vector<int> names_;
  int negative_ = 0;
  mutable Eigen::VectorXd local_;
};

}  // namespace conddp
