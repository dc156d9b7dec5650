#include "nlp/state_chart.hpp"

#include <algorithm>

namespace conddp {
namespace {

using Segment = StateManifold::Segment;
using Block =
    Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;

Block block(const AlignedVector<double>& blocks, std::size_t s, int n) {
  return {blocks.data() + s * StateManifold::kBlockSize, n, n};
}

}  // namespace

StateChart::StateChart(const StateManifold& manifold)
    : manifold_(manifold),
      center_(Eigen::VectorXd::Map(manifold.neutral().data(), manifold.nx())),
      w_(Eigen::VectorXd::Zero(manifold.ndx())),
      jacobian_(manifold.curved().size() * StateManifold::kBlockSize, 0.0),
      inverse_(jacobian_),
      scratch_(jacobian_),
      dual_w_(manifold.ndx(), Dual<double>(0.0)),
      dual_a_(jacobian_.size(), Dual<double>(0.0)),
      dual_b_(dual_a_) {}

void StateChart::set_center(const Eigen::Ref<const Eigen::VectorXd>& x) {
  for (const Segment& s : manifold_.curved()) {
    const int numbers = s.part == StateManifold::Part::se3 ? 7 : 4;
    center_.segment(s.x, numbers) = x.segment(s.x, numbers);
  }
}

void StateChart::state(const double* w, Eigen::Ref<Eigen::VectorXd> x) const {
  manifold_.integrate(center_.data(), w, x.data());
}

void StateChart::coordinates(const Eigen::Ref<const Eigen::VectorXd>& x,
                             Eigen::Ref<Eigen::VectorXd> w) const {
  manifold_.difference(center_.data(), x.data(), w.data());
}

void StateChart::set_point(const Eigen::Ref<const Eigen::VectorXd>& w) {
  w_ = w;
  if (manifold_.curved().empty()) return;
  manifold_.integrate_jacobians(w_.data(), scratch_.data(), jacobian_.data());
  manifold_.inverse_right_jacobian(w_.data(), inverse_.data());
}

void StateChart::pull(Eigen::Ref<Eigen::VectorXd> v) const {
  for (std::size_t i = 0; i < manifold_.curved().size(); ++i) {
    const Segment& s = manifold_.curved()[i];
    v.segment(s.dx, s.n) = (block(jacobian_, i, s.n).transpose() * v.segment(s.dx, s.n)).eval();
  }
}

void StateChart::pull_columns(Eigen::Ref<Eigen::MatrixXd> M) const {
  for (std::size_t i = 0; i < manifold_.curved().size(); ++i) {
    const Segment& s = manifold_.curved()[i];
    M.middleCols(s.dx, s.n) = (M.middleCols(s.dx, s.n) * block(jacobian_, i, s.n)).eval();
  }
}

void StateChart::pull_hessian(Eigen::Ref<Eigen::MatrixXd> H) const {
  pull_columns(H);
  for (std::size_t i = 0; i < manifold_.curved().size(); ++i) {
    const Segment& s = manifold_.curved()[i];
    H.middleRows(s.dx, s.n) =
        (block(jacobian_, i, s.n).transpose() * H.middleRows(s.dx, s.n)).eval();
  }
}

void StateChart::push_rows(Eigen::Ref<Eigen::MatrixXd> M) const {
  for (std::size_t i = 0; i < manifold_.curved().size(); ++i) {
    const Segment& s = manifold_.curved()[i];
    M.middleRows(s.dx, s.n) = (block(inverse_, i, s.n) * M.middleRows(s.dx, s.n)).eval();
  }
}

void StateChart::push_transposed(Eigen::Ref<Eigen::VectorXd> v) const {
  for (std::size_t i = 0; i < manifold_.curved().size(); ++i) {
    const Segment& s = manifold_.curved()[i];
    v.segment(s.dx, s.n) = (block(inverse_, i, s.n).transpose() * v.segment(s.dx, s.n)).eval();
  }
}

// The gradient in coordinates is Rᵀ g. Its derivative is Rᵀ (∂g) + (∂R)ᵀ g; this adds the second
// term. An evaluator gives the symmetric part of ∂g, so only the symmetric part is added here, too.
void StateChart::add_curvature(const Eigen::Ref<const Eigen::VectorXd>& g,
                               Eigen::Ref<Eigen::MatrixXd> H) {
  for (std::size_t i = 0; i < manifold_.curved().size(); ++i) {
    const Segment& s = manifold_.curved()[i];
    for (int j = 0; j < s.n; ++j) {
      for (int a = 0; a < w_.size(); ++a) dual_w_[a] = Dual<double>(w_[a]);
      dual_w_[s.dx + j].d = 1;
      manifold_.integrate_jacobians(dual_w_.data(), dual_a_.data(), dual_b_.data());
      const Dual<double>* R = dual_b_.data() + i * StateManifold::kBlockSize;
      for (int c = 0; c < s.n; ++c) {
        double sum = 0;
        for (int r = 0; r < s.n; ++r) sum += R[r * s.n + c].d * g[s.dx + r];
        H(s.dx + c, s.dx + j) += 0.5 * sum;
        H(s.dx + j, s.dx + c) += 0.5 * sum;
      }
    }
  }
}

// A tangent step δ moves w by R⁻¹ δ. Hence the gradient R⁻ᵀ μ in tangent vectors changes by (∂R⁻¹
// along R⁻¹ δ)ᵀ μ.
const StateChart::Matrix6& StateChart::coordinate_curvature(
    int segment, const Eigen::Ref<const Eigen::VectorXd>& mu) {
  const Segment& s = manifold_.curved()[segment];
  const auto inverse = block(inverse_, segment, s.n);
  Matrix6 half = Matrix6::Zero();
  for (int j = 0; j < s.n; ++j) {
    for (int a = 0; a < w_.size(); ++a) dual_w_[a] = Dual<double>(w_[a]);
    for (int a = 0; a < s.n; ++a) dual_w_[s.dx + a].d = inverse(a, j);
    manifold_.inverse_right_jacobian(dual_w_.data(), dual_a_.data());
    const Dual<double>* L = dual_a_.data() + segment * StateManifold::kBlockSize;
    for (int c = 0; c < s.n; ++c)
      for (int r = 0; r < s.n; ++r) half(c, j) += 0.5 * L[r * s.n + c].d * mu[s.dx + r];
  }
  curvature_ = half + half.transpose();
  return curvature_;
}

double StateChart::angle(const Eigen::Ref<const Eigen::VectorXd>& w) const {
  double largest = 0;
  for (const Segment& s : manifold_.curved())
    largest = std::max(largest, w.segment(s.dx + s.n - 3, 3).norm());
  return largest;
}

}  // namespace conddp
