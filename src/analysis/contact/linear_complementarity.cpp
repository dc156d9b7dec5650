#include "analysis/contact/linear_complementarity.hpp"

#include <cmath>

namespace conddp {
namespace {

/// The tableau w − M z − d z₀ = q, with columns w, z, z₀ and the right-hand side. Its first n
/// columns are always the inverse of the basis.
class Lemke {
 public:
  Lemke(const Eigen::MatrixXd& M, const Eigen::VectorXd& q)
      : n_(static_cast<int>(q.size())), tableau_(n_, 2 * n_ + 2), basis_(n_) {
    tableau_ << Eigen::MatrixXd::Identity(n_, n_), -M, Eigen::VectorXd::Constant(n_, -1.0), q;
    for (int i = 0; i < n_; ++i) basis_[i] = i;
  }

  std::optional<Eigen::VectorXd> solve() {
    int row = 0;
    if (rhs().minCoeff(&row) >= 0) return Eigen::VectorXd::Zero(n_);
    // z₀ enters in the row with the lowest q; ties are broken lexicographically.
    for (int i = 0; i < n_; ++i)
      if (i != row && lower_start(i, row)) row = i;
    int entering = 2 * n_;
    const int pivots = 50 + 20 * n_;
    for (int k = 0; k < pivots; ++k) {
      const int leaving = basis_[row];
      pivot(row, entering);
      if (!rhs().allFinite()) return std::nullopt;
      if (leaving == 2 * n_) return answer();
      entering = leaving < n_ ? leaving + n_ : leaving - n_;
      row = ratio_test(entering);
      if (row < 0) return std::nullopt;
    }
    return std::nullopt;
  }

 private:
  static constexpr double kZero = 1e-12;

  Eigen::MatrixXd::ConstColXpr rhs() const { return tableau_.col(2 * n_ + 1); }

  bool lower_start(int i, int row) const {
    const double difference = rhs()[i] - rhs()[row];
    if (difference != 0) return difference < 0;
    return i > row;  // rows of the identity: the later one is lexicographically lower
  }

  void pivot(int row, int column) {
    tableau_.row(row) /= tableau_(row, column);
    for (int i = 0; i < n_; ++i) {
      if (i == row) continue;
      const double factor = tableau_(i, column);
      if (factor != 0) tableau_.row(i) -= factor * tableau_.row(row);
    }
    basis_[row] = column;
  }

  /// The row that leaves first, or −1 on a ray. z₀ wins every tie, which completes the solution.
  int ratio_test(int column) const {
    const double largest = tableau_.col(column).cwiseAbs().maxCoeff();
    int best = -1;
    for (int i = 0; i < n_; ++i) {
      if (tableau_(i, column) <= kZero * std::max(1.0, largest)) continue;
      if (best < 0 || gives_way_before(i, best, column)) best = i;
    }
    return best;
  }

  bool gives_way_before(int i, int best, int column) const {
    const double a = tableau_(i, column), b = tableau_(best, column);
    const auto compare = [&](int c) {
      const double x = tableau_(i, c) / a, y = tableau_(best, c) / b;
      const double tie = 1e-13 * std::max({1.0, std::abs(x), std::abs(y)});
      return std::abs(x - y) <= tie ? 0 : (x < y ? -1 : 1);
    };
    if (const int order = compare(2 * n_ + 1); order != 0) return order < 0;
    if (basis_[i] == 2 * n_) return true;
    if (basis_[best] == 2 * n_) return false;
    for (int c = 0; c < n_; ++c)
      if (const int order = compare(c); order != 0) return order < 0;
    return false;
  }

  Eigen::VectorXd answer() const {
    Eigen::VectorXd z = Eigen::VectorXd::Zero(n_);
    for (int i = 0; i < n_; ++i)
      if (basis_[i] >= n_ && basis_[i] < 2 * n_) z[basis_[i] - n_] = std::max(0.0, rhs()[i]);
    return z;
  }

  int n_;
  Eigen::MatrixXd tableau_;
  std::vector<int> basis_;
};

}  // namespace

ContactPairs::ContactPairs(int count, int nv)
    : value(Eigen::VectorXd::Zero(count)),
      slope(Eigen::MatrixXd::Zero(count, nv)),
      push(Eigen::MatrixXd::Zero(count, nv)),
      coupling(Eigen::MatrixXd::Zero(count, count)),
      budget(count, false) {}

int ContactPairs::add(double w, const Eigen::RowVectorXd& w_slope,
                      const Eigen::RowVectorXd& impulse) {
  value[filled_] = w;
  slope.row(filled_) = w_slope;
  push.row(filled_) = impulse;
  return filled_++;
}

void ContactPairs::add_friction(const Eigen::MatrixXd& tangents, const Eigen::MatrixXd& slopes,
                                const Eigen::VectorXd& v, const Budget& available) {
  const int first = filled_, slack = filled_ + 2 * static_cast<int>(tangents.rows());
  for (int t = 0; t < tangents.rows(); ++t)
    for (const double sign : {1.0, -1.0}) {
      const int edge =
          add(sign * tangents.row(t).dot(v), sign * slopes.row(t), sign * tangents.row(t));
      coupling(edge, slack) = 1;
    }
  value[slack] = available.constant;
  budget[slack] = true;
  if (available.normal >= 0) coupling(slack, available.normal) = available.factor;
  coupling.row(slack).segment(first, slack - first).setConstant(-1);
  ++filled_;
}

void ContactPairs::rest(int count) {
  value.segment(filled_, count).setOnes();
  filled_ += count;
}

std::optional<int> ContactPairs::slowest_edge(int of, const Eigen::VectorXd& w) const {
  std::optional<int> slowest;
  for (int i = 0; i < w.size(); ++i)
    if (coupling(i, of) == 1 && (!slowest || w[i] < w[*slowest])) slowest = i;
  return slowest;
}

std::optional<Eigen::VectorXd> solve_lcp(const Eigen::MatrixXd& M, const Eigen::VectorXd& q) {
  if (!M.allFinite() || !q.allFinite()) return std::nullopt;
  if (q.size() == 0) return Eigen::VectorXd(0);
  return Lemke(M, q).solve();
}

}  // namespace conddp
