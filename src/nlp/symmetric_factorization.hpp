#pragma once

#include <memory>

namespace conddp {

/// Solves systems with a sparse symmetric matrix that need not be definite, one after another with
/// the same structure.
class SymmetricFactorization {
 public:
  enum class Outcome { done, singular };

  virtual ~SymmetricFactorization() = default;

  /// Takes the structure: rows and columns of `entries` entries of one triangle, from 0. Entries at
  /// one place add up, and one may be named from either side of the diagonal.
  virtual void analyse(int size, int entries, const int* rows, const int* columns) = 0;

  /// Factorizes the matrix with these values, in the order of the structure. A pivot has to be
  /// `pivot_tolerance`, of (0, ½], of the other entries in its column.
  virtual Outcome factorize(const double* values, double pivot_tolerance) = 0;

  /// Replaces b by the solution of A x = b, after `factorize` was `done`.
  virtual void solve(double* b) const = 0;

  /// How many eigenvalues of the factorized matrix are negative.
  virtual int negative_eigenvalues() const = 0;
};

/// Makes a factorization for one sequence of systems.
using MakeFactorization = std::unique_ptr<SymmetricFactorization> (*)();

}  // namespace conddp
