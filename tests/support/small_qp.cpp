#include "support/small_qp.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace conddp::testing {
namespace {

enum Side { kFreeRow, kLowerRow, kUpperRow };

/// True if the optimum with only these rows as equations solves the program.
bool solves(const SmallQp& qp, const std::vector<Side>& sides, SmallQpOptimum& optimum) {
  const int n = static_cast<int>(qp.g.size()), m = static_cast<int>(sides.size());
  std::vector<int> active;
  for (int i = 0; i < m; ++i)
    if (sides[i] != kFreeRow) active.push_back(i);
  const int a = static_cast<int>(active.size());
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n + a, n + a);
  Eigen::VectorXd rhs(n + a);
  K.topLeftCorner(n, n) = qp.H;
  rhs.head(n) = -qp.g;
  for (int j = 0; j < a; ++j) {
    const int i = active[j];
    K.row(n + j).head(n) = qp.A.row(i);
    K.col(n + j).head(n) = qp.A.row(i).transpose();
    rhs[n + j] = sides[i] == kLowerRow ? qp.lower[i] : qp.upper[i];
    if (!std::isfinite(rhs[n + j])) return false;
  }
  const Eigen::FullPivLU<Eigen::MatrixXd> lu(K);
  if (!lu.isInvertible()) return false;
  const Eigen::VectorXd solution = lu.solve(rhs);
  optimum.x = solution.head(n);
  optimum.multipliers.setZero(m);
  for (int j = 0; j < a; ++j) optimum.multipliers[active[j]] = solution[n + j];
  constexpr double kRounding = 1e-11;
  const Eigen::VectorXd values = qp.A * optimum.x;
  for (int i = 0; i < m; ++i) {
    if (values[i] < qp.lower[i] - kRounding || values[i] > qp.upper[i] + kRounding) return false;
    if (qp.lower[i] == qp.upper[i]) continue;
    if (sides[i] == kLowerRow && optimum.multipliers[i] > kRounding) return false;
    if (sides[i] == kUpperRow && optimum.multipliers[i] < -kRounding) return false;
  }
  return true;
}

}  // namespace

SmallQpOptimum enumerate_active_sets(const SmallQp& qp) {
  const int m = static_cast<int>(qp.lower.size());
  std::vector<Side> sides(m);
  for (int i = 0; i < m; ++i) sides[i] = qp.lower[i] == qp.upper[i] ? kLowerRow : kFreeRow;
  SmallQpOptimum optimum;
  for (;;) {
    if (solves(qp, sides, optimum)) return optimum;
    int i = 0;
    for (; i < m; ++i) {  // next base-3 number
      if (qp.lower[i] == qp.upper[i]) continue;
      sides[i] = sides[i] == kUpperRow ? kFreeRow : static_cast<Side>(sides[i] + 1);
      if (sides[i] != kFreeRow) break;
    }
    if (i < m) continue;
    ADD_FAILURE() << "no active set solves the program";
    return {Eigen::VectorXd::Zero(qp.g.size()), Eigen::VectorXd::Zero(m)};
  }
}

}  // namespace conddp::testing
