#pragma once

#include <memory>

namespace conddp {

/// Solves a sequence of sparse symmetric systems of the same structure, which need not be definite.
class SymmetricFactorization {
 public:
  enum class Outcome { done, singular };

  virtual ~SymmetricFactorization() = default;

  /// Sets the structure: rows and columns of `entries` entries of one triangle, from 0. Entries at
  /// the same place add up; an entry may be named from either side of the diagonal.
  virtual void analyse(int size, int entries, const int* rows, const int* columns) = 0;

  /// Factorizes the matrix with these values, in the order of the structure. A pivot must be at
  /// least `pivot_tolerance`, in (0, ½], times the other entries in its column.
  virtual Outcome factorize(const double* values, double pivot_tolerance) = 0;

  /// Replaces b by the solution of A x = b. The last `factorize` must have returned `done`.
  virtual void solve(double* b) const = 0;

  /// Number of negative eigenvalues of the factorized matrix.
  virtual int negative_eigenvalues() const = 0;
};

/// Makes a factorization for one sequence of systems.
using MakeFactorization = std::unique_ptr<SymmetricFactorization> (*)();

}  // namespace conddp
