#include "solvers/riccati/segment_sweep.hpp"

#include <algorithm>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "ocp/evaluation/evaluation_memory.hpp"

namespace conddp {

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
