#include "problem_file/terms/weight_matrix.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/matrix_decompositions.hpp"
#include "base/text/spelling.hpp"
#include "ocp/residuals/weighted_residual.hpp"
#include "ocp/terms/residual.hpp"

namespace conddp {
namespace {

/// Reads a matrix; reports its first error.
class MatrixResolver {
 public:
  MatrixResolver(const MatrixSpec& spec, const ComponentNames& names, const std::string& residual,
                 Diagnostics& out)
      : spec_(spec),
        names_(names),
        residual_(residual),
        out_(out),
        matrix_(Eigen::MatrixXd::Zero(names.size(), names.size())) {}

  std::optional<Eigen::MatrixXd> resolve() {
    const bool read = spec_.entries.empty() ? read_rows() : read_entries();
    if (!read || !is_semidefinite()) return std::nullopt;
    return matrix_;
  }

 private:
  bool fail(const Place& place, std::string message, std::string hint = {}) const {
    out_.error(place, std::move(message), std::move(hint));
    return false;
  }

  bool read_rows() {
    const int n = names_.size();
    if (static_cast<int>(spec_.rows.size()) != n)
      return fail(spec_.place,
                  fmt::format("the matrix has {}, and the residual '{}' has {}",
                              counted(spec_.rows.size(), "row"), residual_, n),
                  list_of(names_));
    const bool lower = is_lower_triangle();
    for (int i = 0; i < n; ++i)
      if (!read_row(i, lower ? i + 1 : n)) return false;
    return lower || is_symmetric();
  }

  bool is_lower_triangle() const {
    return names_.size() > 1 && spec_.rows.front().value.size() == 1;
  }

  bool read_row(int i, int count) {
    const Located<std::vector<double>>& row = spec_.rows[i];
    if (static_cast<int>(row.value.size()) != count)
      return fail(row.place,
                  fmt::format("row {} of the matrix has {}, not {}", i + 1,
                              counted(row.value.size(), "number"), count),
                  "the matrix is square; of the triangle up to the diagonal row i has i numbers");
    for (int j = 0; j < count; ++j) {
      matrix_(i, j) = row.value[j];
      if (is_lower_triangle()) matrix_(j, i) = row.value[j];
    }
    return true;
  }

  bool is_symmetric() const {
    for (int i = 0; i < names_.size(); ++i)
      for (int j = 0; j < i; ++j)
        if (matrix_(i, j) != matrix_(j, i))
          return fail(spec_.rows[i].place,
                      fmt::format("the matrix is not symmetric: row {} has {} in column {}, and "
                                  "row {} has {} in column {}",
                                  i + 1, matrix_(i, j), j + 1, j + 1, matrix_(j, i), i + 1),
                      "write the triangle up to the diagonal alone: '[[2], [1, 3]]'");
    return true;
  }

  bool read_entries() {
    Eigen::MatrixXi given = Eigen::MatrixXi::Zero(matrix_.rows(), matrix_.cols());
    for (const auto& [name, row] : spec_.entries) {
      const auto i = index_of(name);
      if (!i) return false;
      for (const auto& [other, value] : row) {
        const auto j = index_of(other);
        if (!j) return false;
        if (given(*i, *j) && matrix_(*i, *j) != value)
          return fail(other.place,
                      fmt::format("the matrix is not symmetric: '{}' and '{}' have {} "
                                  "and {}",
                                  name.value, other.value, matrix_(*i, *j), value),
                      "an entry is its mirror image, too: write it once");
        matrix_(*i, *j) = matrix_(*j, *i) = value;
        given(*i, *j) = given(*j, *i) = 1;
      }
    }
    return true;
  }

  std::optional<int> index_of(const Name& name) const {
    for (const auto* list : {&names_.names, &names_.second}) {
      const auto found = std::find(list->begin(), list->end(), name.value);
      if (found != list->end()) return static_cast<int>(found - list->begin());
    }
    fail(name.place, fmt::format("'{}' is none of the {}", name.value, names_.what),
         name_hint(name.value, names_.names, names_.what));
    return std::nullopt;
  }

  bool is_semidefinite() const {
    if (least_scaled_eigenvalue(matrix_) >= kLeastWeightEigenvalue) return true;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(matrix_, Eigen::EigenvaluesOnly);
    return fail(spec_.place,
                fmt::format("the matrix is not positive semidefinite: its least eigenvalue is "
                            "{:.6g}",
                            eigen.eigenvalues()[0]));
  }

  const MatrixSpec& spec_;
  const ComponentNames& names_;
  const std::string& residual_;
  Diagnostics& out_;
  Eigen::MatrixXd matrix_;
};

}  // namespace

std::optional<Eigen::MatrixXd> resolve(const MatrixSpec& spec, const CostResidual& residual,
                                       const std::string& name, Diagnostics& out) {
  const int numbers = residual.residual->size() + residual.residual->jacobian_size();
  if (numbers > kMostStackNumbers) {
    out.error(spec.place,
              fmt::format("the residual '{}' is too large for a matrix: {} numbers with its "
                          "derivatives, and at most {} are possible",
                          name, numbers, kMostStackNumbers),
              "write 'weights', one per row");
    return std::nullopt;
  }
  return MatrixResolver(spec, residual.rows, name, out).resolve();
}

}  // namespace conddp
