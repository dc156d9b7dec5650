#include "ocp/residuals/weighted_residual.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "base/matrix_decompositions.hpp"

namespace conddp {
namespace {

/// A block of the residual's Jacobian, for the product with Lᵀ.
struct InnerBlock {
  int row;  ///< its first row
  int rows;
  int first;                 ///< first derivative among those of the residual
  std::vector<int> columns;  ///< places of its columns among those of the group
};

/// Rows of a residual coupled by a matrix or by blocks of the Jacobian.
struct Group {
  std::vector<int> rows;     ///< of the residual, ascending
  std::vector<int> columns;  ///< of z, ascending
  std::vector<InnerBlock> blocks;
  bool affine = true;
  int size = 0;  ///< rows of the product
  /// L by rows: `size` factors for each of the group's rows.
  std::vector<double> factors;
};

/// Disjoint sets of rows.
class RowSets {
 public:
  explicit RowSets(int n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
  int find(int i) const {
    while (parent_[i] != i) i = parent_[i];
    return i;
  }
  void join(int i, int j) {
    const int a = find(i), b = find(j);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<int> parent_;
};

RowSets tied_rows(const Residual& residual, const Eigen::MatrixXd& matrix) {
  const int n = residual.size();
  RowSets sets(n);
  int first = 0;
  for (const RowBlock& block : residual.blocks()) {
    for (int i = 1; i < block.rows; ++i) sets.join(first, first + i);
    first += block.rows;
  }
  for (int j = 0; j < n; ++j)
    for (int i = j + 1; i < n; ++i)
      if (matrix(i, j) != 0) sets.join(i, j);
  return sets;
}

/// Adds the blocks of a group, their columns, and the places of these among the group's columns.
void add_blocks(const Residual& residual, const RowSets& sets, int root, Group& group) {
  std::vector<const RowBlock*> blocks;
  int row = 0, first = 0;
  for (const RowBlock& block : residual.blocks()) {
    if (sets.find(row) == root) {
      blocks.push_back(&block);
      group.blocks.push_back({row, block.rows, first, {}});
      group.affine = group.affine && block.affine;
      group.columns.insert(group.columns.end(), block.columns.begin(), block.columns.end());
    }
    row += block.rows;
    first += block.rows * static_cast<int>(block.columns.size());
  }
  std::sort(group.columns.begin(), group.columns.end());
  group.columns.erase(std::unique(group.columns.begin(), group.columns.end()), group.columns.end());
  for (std::size_t b = 0; b < blocks.size(); ++b)
    for (const int column : blocks[b]->columns) {
      const auto at = std::lower_bound(group.columns.begin(), group.columns.end(), column);
      group.blocks[b].columns.push_back(static_cast<int>(at - group.columns.begin()));
    }
}

void add_factors(const Eigen::MatrixXd& matrix, Group& group) {
  const Eigen::MatrixXd L = weight_factor(matrix(group.rows, group.rows));
  group.size = static_cast<int>(L.cols());
  for (int i = 0; i < L.rows(); ++i)
    for (int j = 0; j < group.size; ++j) group.factors.push_back(L(i, j));
}

/// The groups of rows with nonzero weight, at least one.
std::vector<Group> make_groups(const Residual& residual, const Eigen::MatrixXd& matrix) {
  const RowSets sets = tied_rows(residual, matrix);
  std::vector<Group> groups;
  for (int root = 0; root < residual.size(); ++root) {
    if (sets.find(root) != root) continue;
    Group group;
    for (int i = root; i < residual.size(); ++i)
      if (sets.find(i) == root) group.rows.push_back(i);
    add_factors(matrix, group);
    if (group.size == 0) continue;
    add_blocks(residual, sets, root, group);
    groups.push_back(std::move(group));
  }
  if (!groups.empty()) return groups;
  Group nothing{.rows = {0}, .size = 1, .factors = {0.0}};
  return {nothing};
}

std::vector<RowBlock> structure(const std::vector<Group>& groups) {
  std::vector<RowBlock> blocks;
  for (const Group& group : groups) blocks.push_back({group.size, group.columns, group.affine});
  return blocks;
}

class WeightedResidual : public ResidualBase<WeightedResidual> {
 public:
  WeightedResidual(std::shared_ptr<const Residual> residual, std::vector<Group> groups)
      : ResidualBase(structure(groups), residual->parameter_count(), residual->needs_control()),
        residual_(std::move(residual)),
        groups_(std::move(groups)) {}

  Reads reads() const override { return residual_->reads(); }
  std::vector<std::string> failed_functions() const override {
    return residual_->failed_functions();
  }
  bool has_claimed_hessian() const override { return residual_->has_claimed_hessian(); }

  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    with_stack_numbers<S>(residual_->size(), [&](S* inner) {
      residual_->evaluate(in, inner);
      multiply(inner, r);
    });
  }

  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    const int rows = residual_->size();
    with_stack_numbers<S>(rows + residual_->jacobian_size(), [&](S* inner) {
      residual_->differentiate(in, inner, inner + rows);
      multiply(inner, r);
      std::fill_n(jacobian, jacobian_size(), S(0.0));
      for (const Group& group : groups_) {
        add_jacobian(group, inner + rows, jacobian);
        jacobian += group.size * static_cast<int>(group.columns.size());
      }
    });
  }

 private:
  /// r ← Lᵀ inner.
  template <class S>
  void multiply(const S* inner, S* r) const {
    for (const Group& group : groups_) {
      std::fill_n(r, group.size, S(0.0));
      const double* factor = group.factors.data();
      for (const int row : group.rows)
        for (int i = 0; i < group.size; ++i) r[i] += inner[row] * *factor++;
      r += group.size;
    }
  }

  /// Adds the derivative of a group's rows, by columns, from that of the residual.
  template <class S>
  static void add_jacobian(const Group& group, const S* inner, S* jacobian) {
    const double* factor = group.factors.data();
    for (const InnerBlock& block : group.blocks) {
      const S* entry = inner + block.first;
      for (const int column : block.columns) {
        S* out = jacobian + column * group.size;
        for (int k = 0; k < block.rows; ++k, ++entry)
          for (int i = 0; i < group.size; ++i) out[i] += *entry * factor[k * group.size + i];
      }
      factor += block.rows * group.size;
    }
  }

  std::shared_ptr<const Residual> residual_;
  std::vector<Group> groups_;
};

/// √ of the diagonal, 1 for entries that are not positive.
Eigen::VectorXd scale_of(const Eigen::MatrixXd& matrix) {
  return matrix.diagonal().unaryExpr([](double d) { return d > 0 ? std::sqrt(d) : 1.0; });
}

Eigen::MatrixXd scaled(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& scale) {
  const Eigen::VectorXd inverse = scale.cwiseInverse();
  return inverse.asDiagonal() * matrix * inverse.asDiagonal();
}

/// True if a diagonal entry is negative, or zero in a nonzero row.
bool has_bad_diagonal(const Eigen::MatrixXd& matrix) {
  for (int i = 0; i < matrix.rows(); ++i)
    if (!(matrix(i, i) > 0) && (matrix(i, i) < 0 || !matrix.row(i).isZero(0))) return true;
  return false;
}

}  // namespace

double least_scaled_eigenvalue(const Eigen::MatrixXd& matrix) {
  if (has_bad_diagonal(matrix)) return -std::numeric_limits<double>::infinity();
  const Eigen::MatrixXd C = scaled(matrix, scale_of(matrix));
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(C, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

Eigen::MatrixXd weight_factor(const Eigen::MatrixXd& matrix) {
  if (has_bad_diagonal(matrix))
    throw std::invalid_argument("a weight matrix is positive semidefinite");
  const Eigen::VectorXd scale = scale_of(matrix);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled(matrix, scale));
  const Eigen::VectorXd& values = eigen.eigenvalues();  // ascending
  const int n = static_cast<int>(values.size());
  if (!(values[0] >= kLeastWeightEigenvalue))
    throw std::invalid_argument("a weight matrix is positive semidefinite");
  // Smaller eigenvalues are rounding.
  const double least = n * std::numeric_limits<double>::epsilon() * values[n - 1];
  const int rank = static_cast<int>((values.array() > least).count());
  return scale.asDiagonal() * eigen.eigenvectors().rightCols(rank) *
         values.tail(rank).cwiseSqrt().asDiagonal();
}

std::shared_ptr<const Residual> weighted_residual(std::shared_ptr<const Residual> residual,
                                                  const Eigen::MatrixXd& matrix) {
  const int n = residual->size();
  if (matrix.rows() != n || matrix.cols() != n || matrix != matrix.transpose())
    throw std::invalid_argument("a weight matrix is symmetric and as large as its residual");
  if (n + residual->jacobian_size() > kMostStackNumbers)
    throw std::invalid_argument("the residual is too large for a weight matrix");
  std::vector<Group> groups = make_groups(*residual, matrix);
  return std::make_shared<WeightedResidual>(std::move(residual), std::move(groups));
}

}  // namespace conddp
