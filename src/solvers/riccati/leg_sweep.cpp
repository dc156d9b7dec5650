#include "solvers/riccati/leg_sweep.hpp"

#include <algorithm>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace conddp {

/// Threads that sweep legs.
struct LegSweep::Team {
  explicit Team(int count) : threads(std::max(1, count)), arena(threads) {}

  /// Calls act(0) … act(count − 1), side by side where there are threads.
  template <class F>
  void for_each(int count, F act) {
    if (threads == 1) {
      for (int i = 0; i < count; ++i) act(i);
      return;
    }
    arena.execute([&] { tbb::parallel_for(0, count, act, tbb::simple_partitioner()); });
  }

  int threads;
  tbb::task_arena arena;
};

LegSweep::LegSweep(const ShootingProblem& problem, const Legs& legs)
    : knots_(problem.knots()),
      swept_(legs.count - 1),
      last_(problem),
      true_values_(legs.count - 1, ValueFunction(problem.ndx())),
      start_(Eigen::VectorXd::Zero(problem.ndx())),
      team_(std::make_unique<Team>(std::min(legs.threads, legs.count))) {
  const std::vector<int> first = split(knots_, legs.count);
  for (int leg = 0; leg + 1 < legs.count; ++leg) {
    legs_.emplace_back(problem, leg, first[leg], first[leg + 1], team_->threads);
    joints_.emplace_back(problem.ndx());
  }
}
LegSweep::~LegSweep() = default;

std::vector<int> LegSweep::split(int knots, int legs) {
  std::vector<int> first;
  for (int leg = 0; leg < legs; ++leg)
    first.push_back(std::max(leg, static_cast<int>(1LL * leg * knots / (legs + 1))));
  first.push_back(knots);
  return first;
}

void LegSweep::start_from(const std::vector<ValueFunction>& values) {
  for (ParametricLeg& leg : legs_) leg.end_weight() = values[leg.last()].Vxx;
  started_ = true;
}

std::optional<int> LegSweep::run(const SweptHorizon& horizon, StagePolicy& policy,
                                 Feedback& feedback, std::vector<ValueFunction>& values,
                                 std::vector<Eigen::MatrixXd>& Quu) {
  if (!started_) return std::nullopt;
  const int count = static_cast<int>(legs_.size());
  team_->for_each(count + 1, [&](int i) {
    if (i == count) {
      bad_knot_ = sweep_last(horizon, policy, feedback, values, Quu);
    } else {
      swept_[i] = legs_[i].sweep(horizon, policy, feedback, values, Quu);
      if (swept_[i]) joints_[i].factor(legs_[i]);
    }
  });
  if (bad_knot_ >= 0) return bad_knot_;
  if (std::find(swept_.begin(), swept_.end(), 0) != swept_.end() || !join(values))
    return std::nullopt;
  const int parts = team_->threads;
  team_->for_each(count * parts, [&](int i) {
    const int leg = i / parts;
    legs_[leg].apply(i % parts, horizon, joints_[leg].theta(), policy, feedback, values);
  });
  for (int i = 0; i < count; ++i) legs_[i].end_weight() = true_values_[i].Vxx;
  return -1;
}

int LegSweep::sweep_last(const SweptHorizon& horizon, StagePolicy& policy, Feedback& feedback,
                         std::vector<ValueFunction>& values, std::vector<Eigen::MatrixXd>& Quu) {
  const KnotLinearization& end = horizon.linearization.knots[knots_];
  values[knots_].Vx = end.gradient;
  values[knots_].Vxx = end.hessian();
  const int leg = static_cast<int>(legs_.size());
  for (int k = knots_ - 1; k >= legs_.back().last(); --k) {
    last_.propagate(horizon, k, values[k + 1]);
    Quu[k] = last_.q().Quu();
    if (!last_.solve(horizon, k, last_.q().Qxu(), leg, policy, feedback) ||
        !last_.form_value(values[k], feedback.k[k], true))
      return k;
  }
  return -1;
}

/// True values at the ends of legs, from the last to the first, and then steps there, from the
/// first to the last.
bool LegSweep::join(const std::vector<ValueFunction>& values) {
  const int count = static_cast<int>(legs_.size());
  true_values_[count - 1] = values[legs_.back().last()];
  for (int i = count - 1; i >= 0; --i) {
    if (!joints_[i].meet(legs_[i], true_values_[i])) return false;
    if (i > 0) joints_[i].form_value(legs_[i], values[legs_[i].first()], true_values_[i - 1]);
  }
  for (int i = 0; i < count; ++i) joints_[i].step(legs_[i], i == 0 ? start_ : joints_[i - 1].dx());
  return true;
}

}  // namespace conddp
