// Complementary pairs: solves that tighten their relaxation.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "solvers/common/tuning.hpp"
#include "solvers/ipopt/ipopt_solver.hpp"

namespace conddp {
namespace {

using End = InteriorPointEnd;

/// Barriers of the last solves, whose bounds are those of the answer; they are also the products of
/// multiplier and distance that remain. A bound with a tiny multiplier is missed by the root of
/// that product, and so is stationarity.
constexpr std::array<double, 3> kPolishBarriers = {
    tuning::kWarmBarrier, tuning::kRefinement* tuning::kWarmBarrier,
    tuning::kRefinement* tuning::kRefinement* tuning::kWarmBarrier};

bool pairs_need_no_less(const Transcription& transcription, const Eigen::VectorXd& y,
                        const SolverOptions& options) {
  return transcription.pair_distance(y.data()) <= tuning::kTighter * options.tolerances.constraint;
}

/// A relaxation, and its first epsilon.
struct RelaxationStart {
  PairRelaxation relaxation;
  double initial;
};

/// The chosen relaxation, the same one from a looser epsilon, then the others.
std::vector<RelaxationStart> ways_to_try(const SolverOptions::Complementarity& options) {
  std::vector<RelaxationStart> list = {{options.relaxation, options.initial},
                                       {options.relaxation, options.initial / tuning::kTighter}};
  for (const PairRelaxation other :
       {PairRelaxation::elementwise, PairRelaxation::fischer_burmeister, PairRelaxation::penalty,
        PairRelaxation::inner_product})
    if (other != options.relaxation) list.push_back({other, options.initial});
  return list;
}

}  // namespace

/// Progress of the solves with decreasing epsilon.
struct IpoptSolver::Tightening {
  InteriorPointAnswer last;
  InteriorPointAnswer good;  ///< an answer whose pairs may be told apart
  int failures = 0;          ///< consecutive failures
  bool tried = false;        ///< an attempt to tell the pairs apart was made before the last
                             ///< epsilon
};

bool IpoptSolver::is_complementary(const InteriorPointAnswer& answer) const {
  return transcription_->pair_distance(answer.point.y.data()) <= options_.tolerances.constraint;
}

/// Tries the relaxations until one finds an answer.
InteriorPointAnswer IpoptSolver::run_relaxations(const Trajectory& start) {
  const std::vector<RelaxationStart> ways = ways_to_try(options_.complementarity);
  InteriorPointAnswer answer;
  for (std::size_t i = 0; i < ways.size(); ++i) {
    if (i > 0) {
      make_transcription(ways[i].relaxation);
      transcription_->set_center(start);
      ++row_.fallbacks;
    }
    const bool last = i + 1 == ways.size();
    answer = tighten(start, ways[i].initial,
                     last ? options_.max_iterations
                          : std::max(tuning::kEnough, options_.max_iterations / tuning::kWays));
    if ((answer.is_good() && is_complementary(answer)) || is_out_of_budget()) break;
  }
  return answer;
}

/// Solves with decreasing epsilon, each in at most `iterations`, until the pairs are complementary
/// or can be told apart.
InteriorPointAnswer IpoptSolver::tighten(const Trajectory& start, double initial, int iterations) {
  InteriorPointSettings settings = default_settings();
  settings.max_iterations = iterations;
  Tightening so_far;
  Eigen::VectorXd y = transcription_->point_of(start);
  for (double epsilon = initial;;
       epsilon = std::max(SolverOptions::Complementarity::kLast, tuning::kTighter * epsilon)) {
    InteriorPointAnswer answer = relax_and_run(epsilon, y, settings);
    if (auto end = end_tightening(epsilon, answer, so_far)) return *std::move(end);
    so_far.last = std::move(answer);
    y = so_far.last.point.y;
    settings.warm = so_far.last.is_good() ? &so_far.last.point : nullptr;
    if (epsilon <= SolverOptions::Complementarity::kLast ||
        pairs_need_no_less(*transcription_, y, options_))
      break;
  }
  polish(so_far.last, false);
  return so_far.last;
}

/// Answer that ends the sequence after the solve with this epsilon; empty if it continues.
std::optional<InteriorPointAnswer> IpoptSolver::end_tightening(double epsilon,
                                                               const InteriorPointAnswer& answer,
                                                               Tightening& so_far) {
  if (is_out_of_budget()) return answer;
  so_far.failures = answer.is_good() ? 0 : so_far.failures + 1;
  const bool is_stuck = answer.end == End::max_iterations;
  if (!answer.point.y.allFinite() || is_stuck || so_far.failures == tuning::kFailures)
    return polished_or(std::move(so_far.good), answer);
  const bool may_be_told_apart =
      so_far.failures == 0 && epsilon <= std::sqrt(SolverOptions::Complementarity::kLast);
  return may_be_told_apart ? try_early_polish(epsilon, answer, so_far) : std::nullopt;
}

/// Polishes once, except at the last epsilon, whose answer is always polished.
std::optional<InteriorPointAnswer> IpoptSolver::try_early_polish(double epsilon,
                                                                 const InteriorPointAnswer& answer,
                                                                 Tightening& so_far) {
  if (!so_far.tried && epsilon > SolverOptions::Complementarity::kLast) {
    so_far.tried = true;
    if (auto polished = try_polish(answer)) return polished;
    if (is_out_of_budget()) return answer;
  }
  so_far.good = answer;
  return std::nullopt;
}

/// Solves with one epsilon, to tolerances that match it.
InteriorPointAnswer IpoptSolver::relax_and_run(double epsilon, const Eigen::VectorXd& y,
                                               InteriorPointSettings& settings) {
  row_.relaxation = epsilon;
  transcription_->relax(epsilon);
  settings.tolerance = std::clamp(tuning::kTighter * epsilon, InteriorPointSettings().tolerance,
                                  tuning::kLooseTolerance);
  settings.dual_tolerance = std::max(options_.tolerances.stationarity, settings.tolerance);
  settings.complementarity_tolerance =
      std::max(options_.tolerances.complementarity, settings.tolerance);
  settings.warm_barrier = std::max(tuning::kWarmBarrier, tuning::kTighter * epsilon);
  settings.warm_push = std::max(tuning::kWarmBarrier, tuning::kPushShare * epsilon);
  InteriorPointAnswer answer = run_ipopt(y, settings);
  ++row_.outer;
  iterations_before_ = row_.iteration;
  return answer;
}

/// Polished answer, if its pairs can already be told apart and the result follows from it.
std::optional<InteriorPointAnswer> IpoptSolver::try_polish(InteriorPointAnswer answer) {
  if (polish(answer, true) && crosses_over(answer)) return answer;
  return std::nullopt;
}

/// The last good answer, polished, or else the failed one.
InteriorPointAnswer IpoptSolver::polished_or(InteriorPointAnswer good, InteriorPointAnswer failed) {
  return good.is_good() && polish(good, false) ? good : failed;
}

bool IpoptSolver::is_out_of_budget() const {
  return stop_ != Stop::none || row_.iteration >= options_.max_iterations;
}

/// True if an answer within all tolerances follows from a polished one. It is then the result.
bool IpoptSolver::crosses_over(const InteriorPointAnswer& polished) {
  cross_over_from_polished(polished);
  crossed_over_ = choice_.is_solution();
  iterations_before_ = row_.iteration;
  return crossed_over_;
}

/// A smaller barrier identifies the active bounds better, but its system of equations is harder to
/// resolve. If no answer follows from the last polished one, earlier ones are tried.
void IpoptSolver::cross_over_from_polished(const InteriorPointAnswer& polished) {
  cross_over(polished);
  for (; !looser_.empty() && !choice_.is_solution(); looser_.pop_back()) cross_over(looser_.back());
  looser_.clear();
}

/// Solves again with the smaller variable of each pair fixed to zero, which leaves no relaxation.
/// Further solves use barriers so small that variables can be put on their bounds without harm to
/// the equations. The answer stays unchanged if this fails, or if the cost rises: then the wrong
/// variable of some pair was fixed. A trial has to reach the second barrier in few iterations.
bool IpoptSolver::polish(InteriorPointAnswer& answer, bool trial) {
  std::vector<InteriorPointAnswer> polished = solve_fixed(answer, trial);
  if (polished.size() < (trial ? 2 : 1)) return false;
  answer = std::move(polished.back());
  polished.pop_back();
  looser_ = std::move(polished);
  return true;
}

/// Good answers with the pairs fixed as `answer` tells them.
std::vector<InteriorPointAnswer> IpoptSolver::solve_fixed(const InteriorPointAnswer& answer,
                                                          bool trial) {
  const double before = cost_at(answer);
  transcription_->fix_pairs(answer.point.y.data());
  row_.relaxation = 0;
  std::vector<InteriorPointAnswer> polished;
  polished.reserve(kPolishBarriers.size());
  for (std::size_t solve = 0; solve < kPolishBarriers.size(); ++solve) {
    const PrimalDualPoint& from = solve == 0 ? answer.point : polished.back().point;
    InteriorPointSettings settings = polish_settings(solve, trial);
    settings.warm = &from;
    InteriorPointAnswer fixed = run_polish(from, settings);
    if (!fixed.is_good()) break;
    if (solve == 0 && cost_at(fixed) > before + tuning::kMostGain * (1 + std::abs(before))) break;
    polished.push_back(std::move(fixed));
    if (row_.iteration >= options_.max_iterations) break;
  }
  return polished;
}

InteriorPointSettings IpoptSolver::polish_settings(std::size_t solve, bool trial) const {
  InteriorPointSettings settings = default_settings();
  settings.warm_barrier = kPolishBarriers[solve];
  if (solve > 0) settings.complementarity_tolerance = kPolishBarriers[solve];
  if (trial || solve == 2) settings.max_iterations = tuning::kPolishIterations;
  return settings;
}

double IpoptSolver::cost_at(const InteriorPointAnswer& answer) {
  transcription_->set_point(answer.point.y.data());
  return transcription_->evaluation().cost.sum();
}

/// A solve that ends at its last iteration is good if it meets the requested tolerances.
InteriorPointAnswer IpoptSolver::run_polish(const PrimalDualPoint& from,
                                            const InteriorPointSettings& settings) {
  InteriorPointAnswer fixed = run_ipopt(from.y.cwiseMin(transcription_->upper()), settings);
  ++row_.outer;
  iterations_before_ = row_.iteration;
  if (fixed.end == End::max_iterations && is_as_asked(row_)) fixed.end = End::acceptable;
  return fixed;
}

/// True if the last iterate of a solve is an answer, although rounding kept the solve from the
/// tolerances of its small barrier.
bool IpoptSolver::is_as_asked(const IterationRecord& last) const {
  return under_tolerances({.stationarity = {last.stationarity, last.stationarity_knot},
                           .gap = {last.gap, last.gap_knot},
                           .violation = {last.constraint, last.constraint_knot},
                           .complementarity = last.complementarity});
}

}  // namespace conddp
