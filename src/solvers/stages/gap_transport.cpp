#include "solvers/stages/gap_transport.hpp"

#include <limits>

#include "ocp/evaluation/matrix_vector.hpp"
#include "solvers/common/tuning.hpp"
#include "solvers/linalg/curved_blocks.hpp"

namespace conddp {
namespace {

/// part ← B part, or Bᵀ part, for a row-major block.
template <int n>
void transform_part(const double* B, bool transposed, double* part) {
  const Eigen::Map<const Eigen::Matrix<double, n, n, Eigen::RowMajor>> block(B);
  Eigen::Map<Eigen::Matrix<double, n, 1>> to(part);
  const Eigen::Matrix<double, n, 1> from = to;
  if (transposed) {
    to.noalias() = block.transpose() * from;
  } else {
    to.noalias() = block * from;
  }
}

}  // namespace

GapTransport::GapTransport(const StateManifold& manifold)
    : manifold_(manifold),
      gap_(Eigen::VectorXd::Zero(manifold.ndx())),
      minus_gap_(manifold.ndx()),
      G_(manifold.curved().size() * StateManifold::kBlockSize),
      wrt_dx_(G_.size()) {}

void GapTransport::set(const Eigen::Ref<const Eigen::VectorXd>& gap) {
  none_ = gap.lpNorm<Eigen::Infinity>() <= tuning::kUlps;
  identity_ = none_ || manifold_.curved().empty();
  if (none_) return;
  gap_ = gap;
  if (identity_) return;
  minus_gap_ = -gap;
  manifold_.integrate_jacobians(minus_gap_.data(), G_.data(), wrt_dx_.data());
}

void GapTransport::push(Eigen::Ref<Eigen::VectorXd> delta) const {
  if (!identity_) {
    for (std::size_t s = 0; s < manifold_.curved().size(); ++s) {
      const auto& segment = manifold_.curved()[s];
      (segment.n == 6 ? transform_part<6> : transform_part<3>)(block(s), false,
                                                               delta.data() + segment.dx);
    }
  }
  if (!none_) delta += gap_;
}

void GapTransport::pull(Eigen::Ref<Eigen::VectorXd> lambda) const {
  if (identity_) return;
  for (std::size_t s = 0; s < manifold_.curved().size(); ++s) {
    const auto& segment = manifold_.curved()[s];
    (segment.n == 6 ? transform_part<6> : transform_part<3>)(block(s), true,
                                                             lambda.data() + segment.dx);
  }
}

void GapTransport::pull(ValueFunction& value) const {
  if (none_) return;
  value.Vx.noalias() += value.Vxx * gap_;
  if (identity_) return;
  pull(value.Vx);
  const int ndx = static_cast<int>(value.Vxx.rows());
  for (std::size_t s = 0; s < manifold_.curved().size(); ++s) {
    const auto& segment = manifold_.curved()[s];
    const CurvedBlock G{block(s), segment.n, segment.n};
    transform_rows(G, value.Vxx.data() + segment.dx, ndx, ndx);
    transform_columns(G, value.Vxx.col(segment.dx).data(), ndx, ndx);
  }
}

void GapTransport::pull_gradient(const ValueFunction& value, Eigen::Ref<Eigen::VectorXd> Vx) const {
  Vx = value.Vx;
  if (none_) return;
  multiply_add(value.Vxx, gap_.data(), Vx.data());
  pull(Vx);
}

Gaps::Gaps(const ShootingProblem& problem)
    : knots_(problem.knots(), GapTransport(problem.manifold())) {}

void Gaps::set(const Linearization& linearization, bool open) {
  if (open) return set(linearization.gap);
  norm_ = 0;
  for (GapTransport& knot : knots_) knot.close();
}

void Gaps::set(const Eigen::MatrixXd& gap) {
  norm_ = 0;
  for (std::size_t k = 0; k < knots_.size(); ++k) {
    const auto column = gap.col(static_cast<Eigen::Index>(k));
    knots_[k].set(column);
    if (!knots_[k].closed()) norm_ += column.lpNorm<1>();
  }
}

}  // namespace conddp
