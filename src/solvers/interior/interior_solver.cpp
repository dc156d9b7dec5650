#include "solvers/interior/interior_solver.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "base/stopwatch.hpp"
#include "ocp/evaluation/checkpoint.hpp"
#include "solvers/common/feasible.hpp"
#include "solvers/common/finite_check.hpp"
#include "solvers/common/guess.hpp"
#include "solvers/common/settled_cost.hpp"
#include "solvers/common/tuning.hpp"
#include "solvers/constraints/answer_choice.hpp"
#include "solvers/constraints/answer_gains.hpp"
#include "solvers/iterate/hessian_switch.hpp"

namespace conddp {
namespace {

using namespace tuning::interior;

}  // namespace

InteriorSolver::InteriorSolver(const ShootingProblem& problem, const SolverOptions& options,
                               std::shared_ptr<EvaluationMemory> memory)
    : problem_(problem),
      options_(options),
      bounds_(problem),
      evaluator_(problem,
                 memory ? std::move(memory) : std::make_shared<EvaluationMemory>(options.threads)),
      record_(problem, options_, true),
      terms_(problem, bounds_),
      filter_(options.max_iterations + 1),
      linearization_(problem),
      evaluation_(problem),
      adjoint_(problem, bounds_),
      gaps_(problem),
      sweep_(problem, bounds_),
      stages_(unconstrained_stage(problem)),
      rollout_(problem, bounds_),
      feedback_(problem),
      lagrangian_(problem),
      trajectory_(problem.create_trajectory()),
      trial_(trajectory_),
      answer_(trajectory_),
      rolled_(problem),
      newton_(problem, evaluator_),
      dx_(problem.ndx()),
      multipliers_(Eigen::VectorXd::Zero(problem.constraint_rows())),
      answer_multipliers_(multipliers_),
      penalty_(Eigen::VectorXd::Ones(problem.constraint_rows())),
      is_exact_(problem.knots() + 1),
      linear_costs_(has_linear_costs(problem)) {
  for (const KnotLinearization& knot : linearization_.knots) {
    gradient_.push_back(knot.gradient);
    convex_.push_back(knot.hessian());
  }
  exact_ = convex_;
}

SolveResult InteriorSolver::solve(const Trajectory& guess) {
  check_shape(problem_, guess);
  record_.begin();
  excess_ = std::numeric_limits<double>::infinity();
  const bool by_default = options_.hessian == HessianChoice::automatic;
  if (options_.max_iterations == 0) return judge_guess(guess);
  gauss_newton_ = by_default && exact_hessians_are_dear(problem_) ? kGaussNewton : 0;
  if (terms_.has_pairs()) {
    for (const double width : kFirstRelaxations) {
      const bool last = width == *std::rbegin(kFirstRelaxations);
      const int more = std::max(tuning::kEnough, options_.max_iterations / kTryShare);
      solve_relaxed(guess, width * std::max(kWideRelaxation, options_.complementarity.initial),
                    last ? options_.max_iterations : record_.row.iteration + more);
      if (excess_ <= 1 || out_of_budget()) break;
      ++record_.row.fallbacks;
      gauss_newton_ = 0;
    }
  } else {
    solve_relaxed(guess, 0, options_.max_iterations);
  }
  write_result();
  record_.finished();
  return std::move(record_.result);
}

/// Answers with the guess itself, which is no interior point.
SolveResult InteriorSolver::judge_guess(const Trajectory& guess) {
  take_guess(guess);
  record_.log_row();
  record_.may_continue();
  write_result();
  record_.finished();
  return std::move(record_.result);
}

void InteriorSolver::take_guess(const Trajectory& guess) {
  trajectory_ = guess;
  record_.result.start = "states and controls of the guess";
  clamp_guess(bounds_, trajectory_, record_.result.start);
  correct_states(problem_, trajectory_, record_.result.start);
}

bool InteriorSolver::out_of_budget() const {
  const SolveStatus status = record_.result.status;
  return status == SolveStatus::time_limit || status == SolveStatus::interrupted ||
         status == SolveStatus::cost_settled || record_.row.iteration >= options_.max_iterations;
}

/// Solves from a guess with this first relaxation of pairs, until an iteration limit.
void InteriorSolver::solve_relaxed(const Trajectory& guess, double relaxation, int last_iteration) {
  {
    const CheckpointScope scope([this] {
      if (!record_.result.log.empty() && !record_.budget_left()) throw Abandoned();
    });
    try {
      start(guess, {kFirstBarrier, relaxation, kInside});
      for (const double barrier : kLastBarriers) {
        last_barrier_ = barrier;
        if (!record_.result.log.empty()) ++record_.row.iteration;
        while (run_iteration(last_iteration)) ++record_.row.iteration;
        end_by_newton();
        if (excess_ <= tuning::kTighter || out_of_budget() || terms_.barrier() > barrier) return;
      }
    } catch (const Abandoned&) {
    }
  }
  if (out_of_budget()) end_by_newton();
}

void InteriorSolver::start(const Trajectory& guess, const Start& how) {
  take_guess(guess);
  terms_.enter(trajectory_, how.inside);
  evaluator_.differentiate(trajectory_, linearization_);
  double largest = 0;
  for (const KnotLinearization& knot : linearization_.knots)
    largest = std::max(largest, knot.gradient.lpNorm<Eigen::Infinity>());
  const double scale = std::isfinite(largest) ? std::max(1.0, largest / kLargeGradient) : 1;
  const TermPoint at{trajectory_, linearization_.constraint};
  terms_.start(at, how.barrier * scale, how.relaxation, how.inside);
  feedback_.set_zero();
  filter_.start(infeasibility(linearization_.gap, at));
  weight_ = 0;
  short_steps_ = since_ = 0;
  settled_ = false;
}

const SolveResult& InteriorSolver::iterate(const Trajectory& guess) {
  check_shape(problem_, guess);
  record_.begin();
  // Nodes whose exact Hessian has no minimum cost a sweep each.
  gauss_newton_ = options_.hessian == HessianChoice::exact ? 0 : options_.max_iterations;
  start(guess,
        {kTickBarrier, terms_.has_pairs() ? options_.complementarity.initial : 0, kTickBarrier});
  if (options_.multipliers) terms_.take_equation_multipliers(options_.multipliers->constraints);
  IterationRecord& row = record_.row;
  bool moves = true;
  while (moves && row.iteration < options_.max_iterations) {
    if (!linearize()) {
      end_diverged();
      return record_.finished();
    }
    measure();
    record_.log_row();
    moves = step();
    if (moves) ++row.iteration;
  }
  end_iterated();
  if (moves)
    record_.end(SolveStatus::max_iterations, "ended after {} iterations: {}", row.iteration,
                record_.residual_text());
  return record_.finished();
}

/// Answers a real-time iteration with its last iterate and the policy that led to it.
void InteriorSolver::end_iterated() {
  evaluator_.evaluate(trajectory_, evaluation_);
  linearization_.constraint = evaluation_.constraint;
  linearization_.gap = evaluation_.gap;
  linearization_.cost = evaluation_.cost;
  measure();
  record_.log_row();
  SolveResult& result = record_.result;
  result.trajectory = trajectory_;
  result.cost = record_.row.cost;
  record_.write_residuals();
  terms_.write_multipliers(trajectory_, result.constraint_multipliers);
  std::swap(result.feedback, feedback_);
  result.feedback_regularization = weight_;
}

/// False if the iterations end.
bool InteriorSolver::run_iteration(int last_iteration) {
  if (!linearize()) return end_diverged();
  measure();
  record_.log_row();
  return !lower_barrier() && !cost_settled() && record_.may_continue() &&
         record_.row.iteration < last_iteration && step();
}

bool InteriorSolver::end_diverged() {
  SolveResult& result = record_.result;
  if (const auto where = find_non_finite(linearization_)) {
    result.failed_knot = where->knot;
    result.failed_quantity = where->quantity;
  }
  return record_.end(SolveStatus::diverged, "{} is not finite at knot {}", result.failed_quantity,
                     result.failed_knot);
}

/// Computes derivatives, co-states and residuals of the iterate.
bool InteriorSolver::linearize() {
  const Stopwatch watch(record_.result.times.differentiate);
  terms_.write_row_multipliers(lagrangian_.multiplier);
  evaluator_.differentiate(trajectory_, linearization_, &lagrangian_);
  terms_.add_multipliers(trajectory_, linearization_);
  gaps_.set(linearization_, true);
  adjoint_.compute(linearization_, trajectory_, gaps_, feedback_);
  terms_.measure({trajectory_, linearization_.constraint});
  size_ = std::max(1.0, terms_.mean_multiplier() / kLargeGradient);
  terms_.set_penalty(kPenalty * size_);
  for (std::size_t k = 0; k < gradient_.size(); ++k)
    gradient_[k] = linearization_.knots[k].gradient;
  return !find_non_finite(linearization_) && all_finite(adjoint_.gradient());
}

/// Writes the iterate into the row of the log.
void InteriorSolver::measure() {
  IterationRecord& row = record_.row;
  Extremum stationarity, gap;
  for (int k = 0; k < problem_.knots(); ++k) {
    const auto gradient = adjoint_.gradient().segment(bounds_.offset(k), problem_.nu(k));
    if (gradient.size() > 0) stationarity.meet(gradient.lpNorm<Eigen::Infinity>(), k);
    gap.meet(linearization_.gap.col(k).lpNorm<Eigen::Infinity>(), k);
  }
  const Extremum violation =
      largest_violation(problem_, bounds_, trajectory_, linearization_.constraint);
  row.cost = linearization_.total_cost() + linear_soft_cost(problem_, linearization_.constraint);
  row.stationarity = stationarity.value;
  row.stationarity_knot = stationarity.knot;
  row.gap = gap.value;
  row.gap_knot = gap.knot;
  row.constraint = violation.value;
  row.constraint_knot = violation.knot;
  row.complementarity = row.barrier = terms_.barrier();
  row.relaxation = terms_.relaxation();
}

/// True if the iterate solves the barrier problem.
bool InteriorSolver::barrier_solved() const {
  const double error = kSolved * terms_.barrier();
  return terms_.off_center() <= error * size_ &&
         std::max({adjoint_.gradient().lpNorm<Eigen::Infinity>() / size_, linearization_.max_gap(),
                   terms_.largest_residual()}) <= std::max(error, kExact);
}

/// Lowers the barrier while its problem is solved, and holds pairs as soon as they can be told
/// apart. True if the last problem is solved.
bool InteriorSolver::lower_barrier() {
  for (bool solved = settled_ || barrier_solved(); solved; solved = barrier_solved()) {
    if (terms_.has_free_pairs() && terms_.barrier() <= kPairBarrier) {
      terms_.hold_pairs(trajectory_);
      if (!linearize()) return true;
    } else if (terms_.barrier() <= last_barrier_) {
      return true;
    } else {
      terms_.set_barrier(std::max(last_barrier_, kLower * terms_.barrier()));
      terms_.measure({trajectory_, linearization_.constraint});
    }
    filter_.clear();
    since_ = 0;
  }
  return false;
}

/// Ends the solve if the iterate is feasible and the cost has settled as the caller requires.
bool InteriorSolver::cost_settled() {
  const SolverOptions::Tolerances& tolerances = options_.tolerances;
  if (!cost_has_settled(record_.result.log, tolerances.cost_decrease) ||
      !is_feasible(record_.row, tolerances))
    return false;
  record_.end(SolveStatus::cost_settled, "the cost has settled");
  return true;
}

/// Takes a step, along regularized directions if necessary. False if none is accepted.
bool InteriorSolver::step() {
  record_.row.trials = record_.row.sweeps = 0;
  settled_ = false;
  form_hessians();
  for (int i = 0; i < kTriedDirections && record_.budget_left(); ++i) {
    if (!find_direction()) break;
    if (search()) {
      record_.row.regularization = weight_;
      short_steps_ = record_.row.step < kShortStep ? short_steps_ + 1 : 0;
      if (short_steps_ == tuning::kTries)
        return record_.end(SolveStatus::line_search_failed, "steps remain short");
      if (record_.row.step > kLongStep) weight_ = weight_ < kNoWeight ? 0 : kLighter * weight_;
      return true;
    }
    weight_ = std::max(kFirstWeight, kHeavier * weight_);
  }
  return !out_of_budget() &&
         record_.end(SolveStatus::line_search_failed, "the filter accepts no step");
}

/// Forms the convex and the exact Hessians of the nodes.
void InteriorSolver::form_hessians() {
  const Stopwatch watch(record_.result.times.differentiate);
  const auto take = [this](bool convex, std::vector<Eigen::MatrixXd>& to) {
    for (std::size_t k = 0; k < to.size(); ++k) to[k] = linearization_.knots[k].hessian();
    terms_.add_hessians(trajectory_, convex, to);
  };
  for (std::size_t k = 0; k < gradient_.size(); ++k)
    linearization_.knots[k].gradient = gradient_[k];
  terms_.add_gradients(trajectory_, linearization_);
  terms_.condense(trajectory_, linearization_);
  take(true, convex_);
  use_exact_ = options_.hessian != HessianChoice::gauss_newton && since_++ >= gauss_newton_ &&
               (linear_costs_ || linearization_.max_gap() <= kLargestGap);
  if (!use_exact_) return;
  evaluator_.lagrangian_hessian(trajectory_, adjoint_.costates(), linearization_, &lagrangian_);
  take(false, exact_);
}

/// Finds the step of all variables, and the barrier function's derivative along it.
bool InteriorSolver::find_direction() {
  const Stopwatch watch(record_.result.times.sweep);
  record_.row.exact_hessian = use_exact_ && sweep_exact();
  if (!record_.row.exact_hessian && !sweep_convex()) return false;
  rollout_.run(linearization_, trajectory_, gaps_, feedback_, false);
  limits_ = terms_.expand(linearization_, trajectory_, rollout_);
  double slope = 0;
  for (int k = 0; k <= problem_.knots(); ++k) slope += gradient_[k].dot(rollout_.z(k));
  slope_ = terms_.barrier_slope(slope);
  return true;
}

/// Sweeps with exact Hessians. Where a stage lacks a minimum, small barriers are regularized first;
/// then the node takes the convex one, and the nodes behind it, one by one. False if none are left.
bool InteriorSolver::sweep_exact() {
  const int last = problem_.knots();
  for (int k = 0; k <= last; ++k) linearization_.knots[k].hessian.change() = exact_[k];
  is_exact_.assign(is_exact_.size(), true);
  std::optional<int> from;
  double weight = weight_;
  for (;;) {
    ++record_.row.sweeps;
    int k =
        sweep_.run(linearization_, trajectory_, gaps_, weight, *stages_, feedback_, false, from);
    if (k < 0) return true;
    if (terms_.barrier() < kLeastWeight && weight < kLeastWeight * size_) {
      weight = kLeastWeight * size_;  // rounding hides the curvature of the barrier
      continue;
    }
    while (k <= last && !is_exact_[k]) ++k;
    if (k > last) return false;
    is_exact_[k] = false;
    linearization_.knots[k].hessian.change() = convex_[k];
    from = k == last ? std::nullopt : std::optional(k);
  }
}

/// Sweeps with convex Hessians and as much regularization as rounding requires.
bool InteriorSolver::sweep_convex() {
  for (std::size_t k = 0; k < convex_.size(); ++k)
    linearization_.knots[k].hessian.change() = convex_[k];
  for (; weight_ <= kLargestWeight; weight_ = std::max(kLeastWeight, kHeavier * weight_)) {
    ++record_.row.sweeps;
    if (sweep_.run(linearization_, trajectory_, gaps_, weight_, *stages_, feedback_) < 0)
      return true;
  }
  return false;
}

double InteriorSolver::infeasibility(const Eigen::MatrixXd& gap, const TermPoint& at) const {
  return gap.lpNorm<1>() + terms_.infeasibility(at);
}

/// Halves the step until the filter accepts it. Also true if the step changes θ and φ by rounding
/// only; then the iterate stays, and the barrier problem counts as solved.
bool InteriorSolver::search() {
  const Stopwatch watch(record_.result.times.rollout);
  here_ = {infeasibility(linearization_.gap, {trajectory_, linearization_.constraint}),
           terms_.barrier_function(linearization_.total_cost())};
  terms_.save();
  do {
    double length = limits_.primal;
    for (int i = 0; i < kTriedLengths && !settled_; ++i, length /= 2)
      if (try_length(length)) return true;
  } while (!settled_ && filter_.forget(here_.first));
  terms_.restore();
  record_.row.step = 0;
  return settled_;
}

/// θ and φ of a trial, a step of this length from the saved slacks.
std::pair<double, double> InteriorSolver::judge(double length, const Trajectory& trial) {
  evaluator_.evaluate(trial, evaluation_);
  const TermPoint at{trial, evaluation_.constraint};
  terms_.move(length, trial);
  return {infeasibility(evaluation_.gap, at), terms_.barrier_function(evaluation_.cost.sum())};
}

/// Moves by a step of this length if the filter accepts it: in a straight line, or along the
/// sweep's policy through the dynamics if this is better by an exact penalty.
bool InteriorSolver::try_length(double length) {
  IterationRecord& row = record_.row;
  ++row.trials;
  trial_ = trajectory_;
  for (int k = 0; k <= problem_.knots(); ++k) {
    if (k > 0) {
      dx_ = length * rollout_.dx(k);
      problem_.manifold().integrate(trial_.x(k).data(), dx_.data(), trial_.x(k).data());
    }
    if (k < problem_.knots()) trial_.u(k) += length * rollout_.du(k);
  }
  std::pair<double, double> there = judge(length, trial_);
  const bool bends =
      !((evaluation_.gap - (1 - length) * linearization_.gap).lpNorm<Eigen::Infinity>() <
        tuning::kRounding);
  if (bends)
    evaluator_.roll_out(trajectory_, linearization_.gap, feedback_, length, {.contract_gaps = true},
                        rolled_);
  if (bends && rolled_.first_bad_knot < 0) {
    const double penalty = adjoint_.costates().lpNorm<Eigen::Infinity>();
    const auto merit = [penalty](const std::pair<double, double>& point) {
      return point.second + penalty * point.first;
    };
    const auto rolled = judge(length, rolled_.trajectory);
    if (merit(rolled) < merit(there)) {
      there = rolled;
      std::swap(trial_, rolled_.trajectory);
    } else {
      terms_.move(length, trial_);
    }
  }
  if (!filter_.accepts(length, slope_, here_, there)) {
    const double rounding = tuning::kRounding * std::max(1.0, std::abs(here_.second));
    settled_ = length == limits_.primal &&
               std::abs(there.first - here_.first) <= tuning::kRounding &&
               std::abs(there.second - here_.second) <= rounding;
    return false;
  }
  trajectory_ = trial_;
  terms_.accept(length, limits_.dual);
  row.step = length;
  row.merit = there.second;
  row.expected_decrease = -length * slope_;
  row.actual_decrease = here_.second - there.second;
  return true;
}

/// Puts the iterate on its active bounds and takes Newton steps from there.
void InteriorSolver::end_by_newton() {
  const Stopwatch watch(record_.result.times.sweep);
  terms_.write_multipliers(trajectory_, multipliers_);
  trial_ = trajectory_;
  terms_.snap(trial_);
  newton_.start(trial_, multipliers_, penalty_, feedback_);
  IterationRecord& row = record_.row;
  row.barrier = row.relaxation = 0;
  double last = std::numeric_limits<double>::infinity();
  for (int i = 0;; ++i) {
    newton_.describe(row);
    if (i > 0) {
      ++row.iteration;
      record_.log_row();
    } else if (!record_.result.log.empty()) {
      record_.result.log.back() = row;
    }
    const double now = newton_.norms().largest();
    keep_answer();
    if (i == tuning::kTries || out_of_budget() || now <= tuning::kRounding ||
        (excess_ <= 1 && now > last / 2) || !newton_.step(tuning::kNewtonGrowth))
      break;
    last = now;
  }
}

/// Keeps the iterate of Newton's method if it is the best one so far.
void InteriorSolver::keep_answer() {
  const double excess = AnswerChoice::excess(newton_.norms(), options_.tolerances);
  if (!(excess < excess_)) return;
  excess_ = excess;
  answer_ = newton_.trajectory();
  answer_multipliers_ = newton_.multipliers();
}

/// Gains of Newton steps belong to the iterate before, and those of barriers to no answer. If only
/// controls are bounded, a sweep at the answer gives its own gains. Returns their regularization.
std::optional<double> InteriorSolver::sweep_at_answer() {
  bounds_.snap_rounded(answer_);
  const AnswerGains gains = gains_at(problem_, bounds_, evaluator_, answer_, answer_multipliers_);
  newton_.start(answer_, answer_multipliers_, gains.penalty, gains.feedback);
  return gains.regularization;
}

/// Newton steps that led nowhere may have left the bounds: the answer is the last interior point
/// then. Steps behind the best iterate are taken back.
void InteriorSolver::choose_answer() {
  const auto excess = [this] { return AnswerChoice::excess(newton_.norms(), options_.tolerances); };
  if (excess_ <= 1) {
    if (excess() <= excess_) return;
    feedback_ = newton_.feedback();
    newton_.start(answer_, answer_multipliers_, penalty_, feedback_);
    return;
  }
  answer_ = trajectory_;
  answer_multipliers_ = multipliers_;
  record_.row.newton = 0;
  newton_.start(answer_, answer_multipliers_, penalty_, feedback_);
  excess_ = excess();
}

void InteriorSolver::write_result() {
  choose_answer();
  SolveResult& result = record_.result;
  result.feedback_regularization = problem_.constraints().empty() ? sweep_at_answer() : 0;
  newton_.describe(record_.row);
  if (result.log.empty())
    record_.log_row();
  else
    result.log.back() = record_.row;
  newton_.write_answer(result);
  if (excess_ <= 1)
    record_.end(SolveStatus::converged, record_.residual_text());
  else if (result.message.empty())
    record_.end(SolveStatus::line_search_failed,
                "Newton's method on the active constraints does not reach the tolerances: {}",
                record_.residual_text());
  else if (!out_of_budget())
    result.message += fmt::format(": {}", record_.residual_text());
}

}  // namespace conddp
