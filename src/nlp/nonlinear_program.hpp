#pragma once

#include <vector>

#include <Eigen/Core>

namespace conddp {

/// Structure of a sparse matrix: row and column of each entry, in the order of its values.
struct Sparsity {
  std::vector<int> rows, columns;

  int size() const { return static_cast<int>(rows.size()); }
  void add(int row, int column) {
    rows.push_back(row);
    columns.push_back(column);
  }
};

/// minimize f(y) subject to lower ≤ y ≤ upper, row_lower ≤ g(y) ≤ row_upper, with sparse
/// derivatives of constant structure. Infinite bounds impose no limit; equal bounds are an
/// equality.
class NonlinearProgram {
 public:
  virtual ~NonlinearProgram() = default;

  const Eigen::VectorXd& lower() const { return lower_; }
  const Eigen::VectorXd& upper() const { return upper_; }
  const Eigen::VectorXd& row_lower() const { return row_lower_; }
  const Eigen::VectorXd& row_upper() const { return row_upper_; }
  int variables() const { return static_cast<int>(lower_.size()); }
  int rows() const { return static_cast<int>(row_lower_.size()); }
  const Sparsity& jacobian_structure() const { return jacobian_; }
  /// Lower triangle of the Hessian.
  const Sparsity& hessian_structure() const { return hessian_; }

  /// Sets the point of all evaluations below. The caller checks for values that are not finite.
  virtual void set_point(const double* y) = 0;
  virtual double objective() = 0;
  virtual void gradient(double* out) = 0;
  virtual void constraints(double* out) = 0;
  /// ∂g/∂y in the order of jacobian_structure().
  virtual void jacobian(double* out) = 0;
  /// ∇²(weight f + multipliersᵀ g) in the order of hessian_structure().
  virtual void hessian(double weight, const double* multipliers, double* out) = 0;

 protected:
  Eigen::VectorXd lower_, upper_, row_lower_, row_upper_;
  Sparsity jacobian_, hessian_;
};

}  // namespace conddp
