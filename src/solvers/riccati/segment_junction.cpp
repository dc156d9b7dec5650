#include "solvers/riccati/segment_junction.hpp"

#include <algorithm>
#include <cmath>

#include "solvers/linalg/cholesky.hpp"
#include "solvers/linalg/lane_copy.hpp"
#include "solvers/linalg/lane_gemm.hpp"

namespace conddp {
namespace {

/// Pivots of −S, scaled to a unit diagonal, are rounding up to this size.
constexpr double kRounding = 1e-15;
/// Squared pivots of E below this have lost too many digits against the identity in it.
constexpr double kSmallestPivot = 1e-5;

}  // namespace

SegmentJunction::SegmentJunction(int ndx)
    : ndx_(ndx),
      delta_(ndx, ndx),
      Gt_(ndx, ndx),
      GtDelta_(ndx, ndx),
      E_(ndx, ndx),
      work_(ndx, ndx),
      product_(ndx, ndx),
      sum_(ndx, ndx),
      y_(1, ndx),
      p_(ndx),
      theta_(ndx),
      dx_(ndx),
      rhs_(ndx) {}

/// product_ ← −S scaled to a unit diagonal, rhs_ ← the scale factors, dx_ ← that diagonal, with
/// zeros where S has zeros.
void SegmentJunction::normalize(const ParametricSegment& segment) {
  const auto S = segment.S().view();
  auto& scale = rhs_;
  auto full = product_.view();
  for (int i = 0; i < ndx_; ++i) {
    scale[i] = std::sqrt(std::max(0.0, -S(i, i)));
    dx_[i] = scale[i] > 0 ? 1 : 0;
  }
  for (int j = 0; j < ndx_; ++j)
    for (int i = j; i < ndx_; ++i) {
      const double scales = scale[i] * scale[j];
      full(i, j) = scales > 0 ? -S(i, j) / scales : 0;
      full(j, i) = full(i, j);
    }
}

/// Computes the Cholesky factor of −S, scaled to a unit diagonal, with the largest remaining pivot
/// in each column. Pivots of rounding size are dropped.
void SegmentJunction::factor(const ParametricSegment& segment) {
  normalize(segment);
  const auto& scale = rhs_;
  auto& left = dx_;
  auto full = product_.view();
  LaneMatrix& G = work_;
  for (rank_ = 0; rank_ < ndx_; ++rank_) {
    int pivot = 0;
    const double largest = left.maxCoeff(&pivot);
    if (!(largest > kRounding)) break;
    y_.resize(1, rank_);
    for (int k = 0; k < rank_; ++k) *y_.col(k) = G.col(k)[pivot];
    const LaneBlock column = G.block(ndx_, rank_, 1);
    column.view() = full.col(pivot);
    multiply(Store::subtract, column, G.block(ndx_, 0, rank_), Factor::transposed(y_));
    column.view() /= std::sqrt(largest);
    left -= column.view().cwiseAbs2();
    left[pivot] = 0;
  }
  Gt_.resize(rank_, ndx_);
  Gt_.view() = G.view().leftCols(rank_).transpose() * scale.asDiagonal();
}

bool SegmentJunction::meet(ParametricSegment& segment, const ValueFunction& next) {
  p_ = next.Vx;
  delta_.view() = next.Vxx - segment.end_weight();
  GtDelta_.resize(rank_, ndx_);
  multiply(Store::set, GtDelta_.block(), Gt_.block(), Factor::of(delta_));
  E_.resize(rank_, rank_);
  multiply_lower(Store::set, E_.block(), GtDelta_.block(), Factor::transposed(Gt_));
  E_.view().diagonal().array() += 1;
  if (!cholesky_in_place(E_.block())) return false;
  if (rank_ == 0) return true;
  const double pivot = E_.view().diagonal().minCoeff();
  return pivot * pivot >= kSmallestPivot;
}

void SegmentJunction::form_value(ParametricSegment& segment, const ValueFunction& own,
                                 ValueFunction& value) {
  // Δ G E⁻¹, solved by rows.
  work_.resize(ndx_, rank_);
  transpose(GtDelta_.data(), GtDelta_.stride(), rank_, ndx_, work_.data(), work_.stride());
  solve_rows_in_place(E_.block(), work_.block());
  auto y = rhs_.head(rank_);
  y.noalias() = Gt_.view() * p_;
  theta_ = p_;
  theta_.noalias() -= work_.view() * y;
  product_.flat() = delta_.flat();
  multiply(Store::subtract, product_.block(), work_.block(), Factor::of(GtDelta_));
  theta_.noalias() += product_.view() * segment.s();
  value.Vx = own.Vx;
  value.Vx.noalias() += segment.Lt().view().transpose() * theta_;
  // L Δ' Lᵀ
  work_.resize(ndx_, ndx_);
  multiply(Store::set, work_.block(), product_.block(), Factor::of(segment.Lt()));
  transpose(segment.Lt().data(), segment.Lt().stride(), ndx_, ndx_, product_.data(),
            product_.stride());
  sum_.view() = own.Vxx;
  multiply_lower(Store::add, sum_.block(), product_.block(), Factor::of(work_));
  copy_symmetric(sum_.block(), value.Vxx.data(), ndx_);
}

void SegmentJunction::step(ParametricSegment& segment, const Eigen::VectorXd& dx) {
  dx_ = segment.s();
  dx_.noalias() += segment.Lt().view() * dx;
  theta_ = p_;
  theta_.noalias() += delta_.view() * dx_;
  auto y = rhs_.head(rank_);
  y.noalias() = Gt_.view() * theta_;
  y_.resize(1, rank_);
  y_.view() = y.transpose();
  solve_rows_in_place(E_.block(), y_.block());
  y = y_.view().transpose();
  dx_.noalias() -= Gt_.view().transpose() * y;
  theta_ = p_;
  theta_.noalias() += delta_.view() * dx_;
}

}  // namespace conddp
