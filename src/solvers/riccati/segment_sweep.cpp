#include "solvers/riccati/segment_sweep.hpp"

#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "ocp/evaluation/evaluation_memory.hpp"
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

/// Threads that sweep the segments.
struct SegmentSweep::Team {
  explicit Team(int count) : threads(std::max(1, count)), arena(usable_threads(count)) {}

  /// Calls act(0) … act(count − 1), in parallel if there are several threads.
  template <class F>
  void for_each(int count, F act) {
    if (threads == 1) {
      for (int i = 0; i < count; ++i) act(i);
      return;
    }
    arena.execute([&] { tbb::parallel_for(0, count, act, tbb::simple_partitioner()); });
  }

  int threads;  ///< the work is split for this many; the arena may have fewer
  tbb::task_arena arena;
};

SegmentSweep::SegmentSweep(const ShootingProblem& problem, const Segments& segments)
    : knots_(problem.knots()),
      swept_(segments.count - 1),
      last_(problem),
      true_values_(segments.count - 1, ValueFunction(problem.ndx())),
      start_(Eigen::VectorXd::Zero(problem.ndx())),
      team_(std::make_unique<Team>(std::min(segments.threads, segments.count))) {
  const std::vector<int> first = split(knots_, segments.count);
  for (int segment = 0; segment + 1 < segments.count; ++segment) {
    segments_.emplace_back(problem, segment, first[segment], first[segment + 1], team_->threads);
    junctions_.emplace_back(problem.ndx());
  }
}
SegmentSweep::~SegmentSweep() = default;

std::vector<int> SegmentSweep::split(int knots, int segments) {
  std::vector<int> first;
  for (int segment = 0; segment < segments; ++segment)
    first.push_back(std::max(segment, static_cast<int>(1LL * segment * knots / (segments + 1))));
  first.push_back(knots);
  return first;
}

void SegmentSweep::start_from(const std::vector<ValueFunction>& values) {
  for (ParametricSegment& segment : segments_) segment.end_weight() = values[segment.last()].Vxx;
  started_ = true;
}

std::optional<int> SegmentSweep::run(const SweptHorizon& horizon, StageSolver& stages,
                                     Feedback& feedback, std::vector<ValueFunction>& values,
                                     std::vector<Eigen::MatrixXd>& Quu) {
  if (!started_) return std::nullopt;
  sweep_all(horizon, stages, feedback, values, Quu);
  if (bad_knot_ >= 0) return bad_knot_;
  if (std::find(swept_.begin(), swept_.end(), 0) != swept_.end() || !join(values))
    return std::nullopt;
  const int count = static_cast<int>(segments_.size()), parts = team_->threads;
  team_->for_each(count * parts, [&](int i) {
    const int segment = i / parts;
    segments_[segment].apply(i % parts, horizon, junctions_[segment].theta(), stages.active_set(),
                             feedback, values);
  });
  for (int i = 0; i < count; ++i) segments_[i].end_weight() = true_values_[i].Vxx;
  return -1;
}

/// Sweeps all segments in parallel and stores the outcome in swept_ and bad_knot_.
void SegmentSweep::sweep_all(const SweptHorizon& horizon, StageSolver& stages, Feedback& feedback,
                             std::vector<ValueFunction>& values,
                             std::vector<Eigen::MatrixXd>& Quu) {
  const int count = static_cast<int>(segments_.size());
  team_->for_each(count + 1, [&](int i) {
    if (i == count) {
      bad_knot_ = sweep_last(horizon, stages, feedback, values, Quu);
    } else {
      swept_[i] = segments_[i].sweep(horizon, stages, feedback, values, Quu);
      if (swept_[i]) junctions_[i].factor(segments_[i]);
    }
  });
}

int SegmentSweep::sweep_last(const SweptHorizon& horizon, StageSolver& stages, Feedback& feedback,
                             std::vector<ValueFunction>& values,
                             std::vector<Eigen::MatrixXd>& Quu) {
  const KnotLinearization& end = horizon.linearization.knots[knots_];
  values[knots_].Vx = end.gradient;
  values[knots_].Vxx = end.hessian();
  const int segment = static_cast<int>(segments_.size());
  for (int k = knots_ - 1; k >= segments_.back().last(); --k) {
    last_.propagate(horizon, k, values[k + 1]);
    Quu[k] = last_.q().Quu();
    if (!last_.solve(horizon, k, last_.q().Qxu(), segment, stages, feedback) ||
        !last_.form_value(values[k], feedback.k[k], true))
      return k;
  }
  return -1;
}

/// Computes the true values at the segment ends, from the last to the first, and then the steps
/// there, from the first to the last.
bool SegmentSweep::join(const std::vector<ValueFunction>& values) {
  const int count = static_cast<int>(segments_.size());
  true_values_[count - 1] = values[segments_.back().last()];
  for (int i = count - 1; i >= 0; --i) {
    if (!junctions_[i].meet(segments_[i], true_values_[i])) return false;
    if (i > 0)
      junctions_[i].form_value(segments_[i], values[segments_[i].first()], true_values_[i - 1]);
  }
  for (int i = 0; i < count; ++i)
    junctions_[i].step(segments_[i], i == 0 ? start_ : junctions_[i - 1].dx());
  return true;
}

}  // namespace conddp
