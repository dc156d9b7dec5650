// Complementary pairs: the solves that tighten their relaxation.
#include <algorithm>

#include "solvers/ipopt_solver.hpp"

namespace conddp {
namespace {

using End = InteriorPointEnd;

bool is_good(const InteriorPointAnswer& answer) {
  return answer.end == End::solved || answer.end == End::acceptable;
}

/// Of the solves before the last one, which need no more than a good start for the next.
constexpr double kLooseTolerance = 1e-3, kTightTolerance = 1e-8;
/// Solves in a row that may fail before the relaxation is given up.
constexpr int kFailures = 2;
/// Smallest barrier with which the next solve starts.
constexpr double kLeastBarrier = 1e-9;
/// Of the last solve, whose bounds are those of the answer, and what it leaves of multiplier times
/// distance.
constexpr double kPolishBarrier = 1e-11, kPolishComplementarity = 1e-11;
/// The barrier with which a solve starts, and the tolerance to which it is solved, as a share of
/// its epsilon.
constexpr double kBarrierShare = 0.1;
/// How far the next solve's start is pushed from bounds, as a share of its epsilon: pairs have to
/// come closer, and what stands at its bound moves in many small steps only.
constexpr double kPushShare = 1e-2, kLeastPush = 1e-9;
/// Share of the tolerance at which pairs need no smaller epsilon.
constexpr double kComplementary = 0.1;

}  // namespace

bool IpoptSolver::is_complementary(const InteriorPointAnswer& answer) const {
  return transcription_->pair_distance(answer.point.y.data()) <= options_.tolerances.constraint;
}

/// The chosen relaxation, then the others until one finds an answer.
InteriorPointAnswer IpoptSolver::run_relaxations(const Trajectory& start) {
  std::vector<PairRelaxation> ways = {options_.complementarity.relaxation};
  if (options_.complementarity.fallback == RelaxationFallback::automatic)
    for (const PairRelaxation way :
         {PairRelaxation::elementwise, PairRelaxation::fischer_burmeister, PairRelaxation::penalty,
          PairRelaxation::inner_product})
      if (way != ways.front()) ways.push_back(way);
  InteriorPointAnswer answer;
  for (std::size_t i = 0; i < ways.size(); ++i) {
    if (i > 0) {
      make_transcription(ways[i]);
      transcription_->set_center(start);
      ++row_.fallbacks;
    }
    answer = tighten(start);
    if (is_good(answer) && is_complementary(answer)) break;
    if (stop_ != Stop::none || row_.iteration >= options_.max_iterations) break;
  }
  return answer;
}

/// Solves with smaller and smaller epsilon until the pairs are complementary.
InteriorPointAnswer IpoptSolver::tighten(const Trajectory& start) {
  const auto& schedule = options_.complementarity;
  InteriorPointSettings settings = default_settings();
  const auto set_tolerances = [&](double tolerance) {
    settings.tolerance = tolerance;
    settings.dual_tolerance = std::max(options_.tolerances.stationarity, tolerance);
    settings.complementarity_tolerance = std::max(options_.tolerances.complementarity, tolerance);
  };
  InteriorPointAnswer last;
  Eigen::VectorXd y = transcription_->point_of(start);
  int failures = 0;
  for (double epsilon = schedule.initial;;
       epsilon = std::max(schedule.final, epsilon * schedule.factor)) {
    row_.relaxation = epsilon;
    transcription_->relax(epsilon);
    set_tolerances(std::clamp(kBarrierShare * epsilon, kTightTolerance, kLooseTolerance));
    settings.warm_barrier = std::max(kLeastBarrier, kBarrierShare * epsilon);
    settings.warm_push = std::max(kLeastPush, kPushShare * epsilon);
    InteriorPointAnswer answer = run_ipopt(y, settings);
    ++row_.outer;
    iterations_before_ = row_.iteration;
    if (stop_ != Stop::none || row_.iteration >= options_.max_iterations) return answer;
    failures = is_good(answer) ? 0 : failures + 1;
    if (!answer.point.y.allFinite() || failures == kFailures) return answer;
    last = std::move(answer);
    y = last.point.y;
    settings.warm = is_good(last) ? &last.point : nullptr;
    if (epsilon <= schedule.final ||
        transcription_->pair_distance(y.data()) <= kComplementary * options_.tolerances.constraint)
      break;
  }
  polish(last);
  return last;
}

/// Solves once more with the smaller one of each pair fixed to zero, which leaves nothing relaxed,
/// and then with a barrier so small that what belongs at a bound can be put there without harm to
/// the equations. The answer stays as it was where that fails.
void IpoptSolver::polish(InteriorPointAnswer& answer) {
  transcription_->fix_pairs(answer.point.y.data());
  InteriorPointSettings settings = default_settings();
  row_.relaxation = 0;
  for (const double barrier : {kLeastBarrier, kPolishBarrier}) {
    const Eigen::VectorXd y = answer.point.y.cwiseMin(transcription_->upper());
    settings.warm = &answer.point;
    settings.warm_barrier = barrier;
    InteriorPointAnswer fixed = run_ipopt(y, settings);
    ++row_.outer;
    iterations_before_ = row_.iteration;
    if (!is_good(fixed)) return;
    answer = std::move(fixed);
    if (row_.iteration >= options_.max_iterations) return;
    settings.complementarity_tolerance = kPolishComplementarity;
  }
}

}  // namespace conddp
