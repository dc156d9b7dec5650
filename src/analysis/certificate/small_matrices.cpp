#include "analysis/certificate/small_matrices.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "spatial/lane_memory.hpp"

namespace conddp {
namespace {

using Eigen::Index;

/// to −= factor · from.
void subtract(double factor, const double* from, Index count, double* to) {
  for (Index i = 0; i < count; ++i) to[i] -= factor * from[i];
}

void scale(double factor, Index count, double* numbers) {
  for (Index i = 0; i < count; ++i) numbers[i] *= factor;
}

using Eigen::Index;

/// Calls f with the first index of each of the blocks of `size` that cover `count`. The last block
/// overlaps the one before it; entries written twice are the same.
template <int size, class F>
void cover(Index count, F f) {
  for (Index first = 0; first + size <= count; first += size) f(first);
  if (count % size != 0) f(count - size);
}

/// Entries of consecutive rows in one column of a matrix.
template <int rows>
struct Rows {
  // A `using` alias loses an attribute that depends on a template parameter.
  typedef double Vector __attribute__((vector_size(8 * rows)));  // NOLINT(modernize-use-using)
  static Vector load(const double* from) {
    Vector v;
    std::memcpy(&v, from, sizeof v);
    return v;
  }
  static void store(Vector v, double* to) { std::memcpy(to, &v, sizeof v); }
};
template <>
struct Rows<1> {
  static double load(const double* from) { return *from; }
  static void store(double v, double* to) { *to = v; }
};

struct Product {
  const double* a;
  const double* b;
  double* out;
  Index a_stride, b_stride, out_stride, terms;
  bool lower;  ///< true if blocks above the diagonal are skipped

  template <int rows, int columns>
  void block(Index row, Index column) const {
    decltype(Rows<rows>::load(a)) sums[columns] = {};
    const double* left = a + row;
    const double* right = b + column * b_stride;
    for (Index k = 0; k < terms; ++k, left += a_stride, ++right) {
      const auto entries = Rows<rows>::load(left);
      for (int j = 0; j < columns; ++j) sums[j] += entries * right[j * b_stride];
    }
    for (int j = 0; j < columns; ++j)
      Rows<rows>::store(sums[j], out + row + (column + j) * out_stride);
  }

  template <int rows, int columns>
  void blocks(Index height, Index width) const {
    cover<columns>(width, [&](Index column) {
      cover<rows>(height, [&](Index row) {
        if (!lower || row + rows > column) block<rows, columns>(row, column);
      });
    });
  }

  /// Uses the largest blocks that are not wider than the product.
  template <int rows, int columns>
  void run(Index height, Index width) const {
    if constexpr (columns > 1)
      if (width < columns) return run<rows, columns / 2>(height, width);
    if constexpr (rows > 1)
      if (height < rows) return run<rows / 2, columns>(height, width);
    blocks<rows, columns>(height, width);
  }
};

/// Adds the sum over the lanes of each of the first `count` entries of `sums` to `to`.
void add_totals(Lane (&sums)[kLaneWidth], int count, double* to) {
  transpose_lanes(sums);
  Lane total = load_some(to, count);
  for (const Lane& lane : sums) total += lane;
  store_some(to, total, count);
}

void form_product(const Eigen::Ref<const Eigen::MatrixXd>& a,
                  const Eigen::Ref<const Eigen::MatrixXd>& b, bool lower, Eigen::MatrixXd& out) {
  constexpr int kColumns = 8;
  out.resize(a.rows(), b.cols());
  if (out.size() == 0) return;
  const Product product{a.data(),        b.data(),          out.data(), a.outerStride(),
                        b.outerStride(), out.outerStride(), a.cols(),   lower};
  product.run<kLaneWidth, kColumns>(out.rows(), out.cols());
}

}  // namespace

void multiply(const Eigen::Ref<const Eigen::MatrixXd>& a,
              const Eigen::Ref<const Eigen::MatrixXd>& b, Eigen::MatrixXd& out) {
  form_product(a, b, false, out);
}

void multiply_lower(const Eigen::Ref<const Eigen::MatrixXd>& a,
                    const Eigen::Ref<const Eigen::MatrixXd>& b, Eigen::MatrixXd& out) {
  form_product(a, b, true, out);
}

void mirror_lower_triangle(Eigen::MatrixXd& matrix) {
  for (Index column = 1; column < matrix.cols(); ++column)
    for (Index row = 0; row < column; ++row) matrix(row, column) = matrix(column, row);
}

void add_transposed_product(const Eigen::MatrixXd& A, const double* x, Eigen::VectorXd& value,
                            Eigen::VectorXd& size) {
  const int rows = static_cast<int>(A.rows()), columns = static_cast<int>(A.cols());
  if (rows == 0) return;
  for (int first = 0; first < columns; first += kLaneWidth) {
    const int count = std::min(kLaneWidth, columns - first);
    Lane sums[kLaneWidth], sizes[kLaneWidth];
    for (int j = 0; j < kLaneWidth; ++j) {
      sums[j] = sizes[j] = Lane(0.0);
      if (j >= count) continue;
      const double* column = A.col(first + j).data();
      for (int i = 0; i < rows; i += kLaneWidth) {
        const Lane term = load_some(column + i, rows - i) * load_some(x + i, rows - i);
        sums[j] += term;
        sizes[j] += abs(term);
      }
    }
    add_totals(sums, count, value.data() + first);
    add_totals(sizes, count, size.data() + first);
  }
}

bool SmallCholesky::factorize(const Eigen::Ref<const Eigen::MatrixXd>& A, double least) {
  const Index n = A.rows();
  L_ = A;
  inverse_.resize(n);
  const double threshold = least * std::max(0.0, n == 0 ? 0.0 : A.diagonal().maxCoeff());
  for (Index k = 0; k < n; ++k) {
    const double pivot = L_(k, k);
    if (!(pivot > 0) || !(pivot > threshold)) return false;
    inverse_[k] = 1 / std::sqrt(pivot);
    double* column = L_.col(k).data();
    scale(inverse_[k], n - k, column + k);
    for (Index j = k + 1; j < n; ++j) subtract(column[j], column + j, n - j, &L_(j, j));
  }
  return true;
}

void SmallCholesky::solve(Rows& rhs) const {
  const Index n = L_.rows(), width = rhs.cols();
  for (Index i = 0; i < n; ++i) {
    double* row = rhs.row(i).data();
    for (Index k = 0; k < i; ++k) subtract(L_(i, k), rhs.row(k).data(), width, row);
    scale(inverse_[i], width, row);
  }
  for (Index i = n - 1; i >= 0; --i) {
    double* row = rhs.row(i).data();
    for (Index k = i + 1; k < n; ++k) subtract(L_(k, i), rhs.row(k).data(), width, row);
    scale(inverse_[i], width, row);
  }
}

}  // namespace conddp
