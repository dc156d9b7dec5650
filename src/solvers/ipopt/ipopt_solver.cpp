#include "solvers/ipopt/ipopt_solver.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "nlp/chain_factorization.hpp"
#include "nlp/inequality_elimination.hpp"
#include "ocp/problem/problem.hpp"
#include "solvers/common/feasible.hpp"
#include "solvers/common/finite_check.hpp"
#include "solvers/common/guess.hpp"
#include "solvers/common/settled_cost.hpp"
#include "solvers/common/tuning.hpp"
#include "solvers/iterate/hessian_switch.hpp"

namespace conddp {
namespace {

using End = InteriorPointEnd;

/// Maximum number of log rows reserved before the first iteration.
constexpr int kReservedRows = 10000;

double seconds_since(std::chrono::steady_clock::time_point began) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
}

/// Statuses of ends outside this solver's tolerances. All other ends mean that no step was found.
constexpr std::pair<End, SolveStatus> kStatuses[] = {
    {End::max_iterations, SolveStatus::max_iterations},
    {End::time_limit, SolveStatus::time_limit},
    {End::infeasible, SolveStatus::infeasible},
    {End::no_factorization, SolveStatus::regularization_limit},
    {End::diverging, SolveStatus::diverged},
    {End::not_finite, SolveStatus::diverged},
};

SolveStatus status_of(End end) {
  const auto* found = std::find_if(std::begin(kStatuses), std::end(kStatuses),
                                   [&](const auto& entry) { return entry.first == end; });
  return found == std::end(kStatuses) ? SolveStatus::line_search_failed : found->second;
}

/// True if options determine how a solve without multipliers starts.
bool is_told_how_to_begin(const IpoptOptions& options) {
  return std::any_of(options.begin(), options.end(), [](const auto& option) {
    const std::string& name = option.first;
    return name == "mu_init" || name.starts_with("constr_mult_init") ||
           name.starts_with("bound_") || name.starts_with("slack_bound_");
  });
}

bool wants_limited_memory(const IpoptOptions& options) {
  return std::any_of(options.begin(), options.end(), [](const auto& option) {
    const auto* text = std::get_if<std::string>(&option.second);
    return option.first == "hessian_approximation" && text != nullptr && *text != "exact";
  });
}

}  // namespace

MakeFactorization factorization_along_horizon(const ShootingProblem& problem) {
  int directions = problem.ndx();
  for (int k = 0; k < problem.knots(); ++k) directions += problem.knot(k).model->nz();
  if (problem.constraint_rows() <= 2 * directions) return ChainFactorization::make;
  int equalities = 0;
  for (const NodeConstraint& constraint : problem.constraints())
    for (int i = 0; constraint.lower != nullptr && i < constraint.term->rows; ++i)
      equalities += constraint.lower[i] == constraint.upper[i];
  return equalities <= 2 * directions ? InequalityElimination::make : nullptr;
}

IpoptSolver::IpoptSolver(const ShootingProblem& problem, const SolverOptions& options)
    : problem_(problem),
      options_(options),
      gauss_newton_(options.hessian == HessianChoice::gauss_newton),
      bounds_(problem),
      evaluator_(problem, options.threads),
      newton_(problem, evaluator_),
      choice_(options.tolerances),
      result_(problem) {
  make_transcription(options.complementarity.relaxation);
}

void IpoptSolver::make_transcription(PairRelaxation relaxation) {
  transcription_ = std::make_unique<Transcription>(
      problem_, evaluator_,
      Transcription::Options{.gauss_newton = gauss_newton_,
                             .cone_smoothing = tuning::kTighter * options_.tolerances.constraint,
                             .relaxation = relaxation,
                             .epsilon = options_.complementarity.initial});
  best_ = Eigen::VectorXd::Zero(transcription_->variables());
}

SolveResult IpoptSolver::solve(const Trajectory& guess) {
  began_ = std::chrono::steady_clock::now();
  check_shape(problem_, guess);
  reset();
  const Trajectory start = start_from(guess);
  if (options_.multipliers && !transcription_->has_pairs() && newton_is_enough(start)) {
    result_.iterations = row_.iteration;
    result_.times.total = result_.times.sweep = elapsed();
    return std::move(result_);
  }
  transcription_->set_center(start);
  InteriorPointAnswer answer = transcription_->has_pairs()
                                   ? run_relaxations(start)
                                   : run_ipopt(transcription_->point_of(start), default_settings());
  const double newton_began = elapsed();
  if (!crossed_over_) cross_over_from_polished(answer);
  if (!transcription_->has_pairs()) refine(answer);
  sweep_at_answer();
  log_answer();
  set_status(answer);
  result_.iterations = row_.iteration;
  result_.times.total = elapsed();
  result_.times.sweep += result_.times.total - newton_began;
  return std::move(result_);
}

/// Guess within the control bounds and on the state manifold.
Trajectory IpoptSolver::start_from(const Trajectory& guess) {
  Trajectory start = guess;
  result_.start = "states and controls of the guess";
  if (options_.multipliers && options_.multipliers->costates.size() > 0)
    result_.start += "; its multipliers";
  clamp_guess(bounds_, start, result_.start);
  correct_states(problem_, start, result_.start);
  result_.trajectory = start;
  return start;
}

void IpoptSolver::reset() {
  result_ = SolveResult(problem_);
  result_.log.reserve(std::min(options_.max_iterations, kReservedRows) + tuning::kTries + 1);
  row_ = IterationRecord();
  row_.exact_hessian = !gauss_newton_ && !wants_limited_memory(options_.ipopt);
  alternates_ = row_.exact_hessian && alternation_pays();
  iterations_before_ = 0;
  scales_.reset();
  choice_.forget();
  looser_.clear();
  crossed_over_ = false;
}

InteriorPointSettings IpoptSolver::default_settings() const {
  return {.max_iterations = options_.max_iterations,
          .dual_tolerance = options_.tolerances.stationarity,
          .violation_tolerance = std::min(options_.tolerances.gap, options_.tolerances.constraint),
          .complementarity_tolerance = options_.tolerances.complementarity,
          .minimum_fill = !transcription_->has_pairs(),
          .make_factorization = factorization_along_horizon(problem_),
          .options = options_.ipopt};
}

/// Exact Hessians are used throughout if they are cheap. So are those of constrained contact
/// forces: Gauss-Newton Hessians would omit their curvature, and their steps lead far away.
bool IpoptSolver::alternation_pays() const {
  if (options_.hessian != HessianChoice::automatic || transcription_->has_pairs() ||
      transcription_->has_mixed_rows())
    return false;
  return exact_hessians_are_dear(problem_);
}

/// From multipliers near a solution, Newton's method on the active set suffices. An interior-point
/// method would first leave the bounds.
bool IpoptSolver::newton_is_enough(const Trajectory& start) {
  start_newton(start, options_.multipliers->constraints);
  record();
  consider();
  while (!choice_.is_solution() && row_.iteration < tuning::kTries && newton_.step())
    note_newton_step();
  if (choice_.is_solution()) {
    sweep_at_answer();
    log_answer();
    set_status({});
    return true;
  }
  choice_.forget();
  result_.log.clear();
  const bool exact = row_.exact_hessian;
  row_ = IterationRecord();
  row_.exact_hessian = exact;
  return false;
}

/// True if the guess has multipliers of all rows that Ipopt sees.
bool IpoptSolver::knows_multipliers() const {
  return options_.multipliers && options_.multipliers->costates.size() > 0 &&
         !transcription_->has_pairs();
}

/// If a state sums up a cost, the curvature of that cost appears only in the multipliers of the
/// state's equation. These are known: the slope of the linear cost on its final value. Ipopt's own
/// initial multipliers minimize the Lagrangian's gradient, and over long motions they are nearly
/// zero. Its first steps then go wherever the linearized cost falls. Large multipliers, as for
/// unstable motions, are not informative.
void IpoptSolver::start_with_multipliers(const Eigen::VectorXd& y, InteriorPointSettings& settings,
                                         PrimalDualPoint& first) {
  if (!has_linear_costs(problem_) || transcription_->has_pairs() ||
      settings.make_factorization == nullptr || is_told_how_to_begin(settings.options))
    return;
  transcription_->set_point(y.data());
  const Eigen::VectorXd weights = transcription_->weights_of_cost_states(tuning::kCostStatesFirst);
  if (weights.maxCoeff() == 1) return;
  const auto rows = first_multipliers(*transcription_, weights, settings.make_factorization);
  if (!rows || rows->lpNorm<Eigen::Infinity>() > tuning::kLargestFirst) return;
  first = {.y = y,
           .rows = *rows,
           .lower = Eigen::VectorXd::Ones(y.size()),
           .upper = Eigen::VectorXd::Ones(y.size())};
  settings.warm = &first;
  settings.warm_barrier = tuning::kColdBarrier;
  settings.warm_push = tuning::kColdPush;
}

/// Runs Ipopt, again from the last iterate whenever that has left the middle of its charts.
InteriorPointAnswer IpoptSolver::run_ipopt(Eigen::VectorXd y, InteriorPointSettings settings) {
  InteriorPointAnswer answer;
  const int allowed = settings.max_iterations;
  PrimalDualPoint known;
  if (settings.warm == nullptr && knows_multipliers()) {
    const DualGuess& duals = *options_.multipliers;
    known.y = y;
    transcription_->write_multipliers(duals.costates, duals.constraints, duals.control_gradient,
                                      known.rows, known.lower, known.upper);
    settings.warm = &known;
    settings.warm_barrier = tuning::kWarmBarrier;
  }
  if (settings.warm == nullptr) start_with_multipliers(y, settings, known);
  for (;;) {
    stop_ = Stop::none;
    const double began = elapsed();
    settings.max_iterations = std::min(allowed, options_.max_iterations - iterations_before_);
    answer = minimise(*transcription_, y, settings,
                      [this](const InteriorPointIterate& iterate) { return note(iterate); });
    result_.times.differentiate += answer.evaluation_seconds;
    result_.times.sweep += elapsed() - began - answer.evaluation_seconds;
    if (stop_ != Stop::recenter) return answer;
    iterations_before_ = row_.iteration;
    transcription_->set_point(answer.point.y.data());
    transcription_->recenter_multipliers(answer.point.rows.data());
    const Trajectory center = transcription_->trajectory();
    transcription_->set_center(center);
    y = best_ = transcription_->point_of(center);
    settings.warm = &answer.point;
    settings.warm_barrier = answer.barrier;
    settings.warm_push = InteriorPointSettings().warm_push;
  }
}

/// Records an iterate; returns false if Ipopt should stop.
bool IpoptSolver::note(const InteriorPointIterate& iterate) {
  const bool again = iterations_before_ > 0 && iterate.iteration == 0;
  if (alternates_) alternate_hessians(iterate, again);
  describe(iterate);
  keep_if_best(iterate, again);
  if (!again) {
    result_.log.push_back(row_);
    if (options_.on_iteration) options_.on_iteration(row_);
  }
  stop_ = reason_to_stop(iterate);
  if (stop_ == Stop::cost_settled)
    best_ = Eigen::Map<const Eigen::VectorXd>(iterate.y, best_.size());
  return stop_ == Stop::none;
}

/// Excludes the restoration phase, which has its own optimality error.
void IpoptSolver::keep_if_best(const InteriorPointIterate& iterate, bool again) {
  const double error =
      std::max({row_.gap, row_.constraint, row_.stationarity, row_.complementarity});
  if (row_.iteration == 0 || again || (!iterate.restoration && error < best_error_)) {
    best_ = Eigen::Map<const Eigen::VectorXd>(iterate.y, best_.size());
    best_error_ = error;
  }
}

/// `again`: the first iterate of a run that continues the one before.
void IpoptSolver::alternate_hessians(const InteriorPointIterate& iterate, bool again) {
  if (iterate.iteration > 0) {
    row_.exact_hessian = !alternation_.gauss_newton();
    alternation_.watch(iterate);
  } else if (!again) {
    alternation_.begin(iterate);
  }
  transcription_->use_gauss_newton(alternation_.gauss_newton());
}

/// Writes an Ipopt iterate into the row of the log.
void IpoptSolver::describe(const InteriorPointIterate& iterate) {
  transcription_->set_point(iterate.y);
  const Evaluation& values = transcription_->evaluation();
  row_.iteration = iterations_before_ + iterate.iteration;
  row_.cost = row_.merit = values.cost.sum() + linear_soft_cost(problem_, values.constraint);
  row_.stationarity = iterate.dual_infeasibility;
  row_.stationarity_knot = -1;
  row_.gap = values.gap.size() == 0 ? 0 : values.gap.cwiseAbs().maxCoeff();
  row_.gap_knot = -1;
  const Extremum violation =
      largest_violation(problem_, bounds_, transcription_->trajectory(), values.constraint);
  row_.constraint = violation.value;
  row_.constraint_knot = violation.knot;
  row_.complementarity = iterate.complementarity;
  row_.barrier = iterate.barrier;
  row_.step = iterate.step;
  row_.regularization = iterate.regularization;
  row_.trials = iterate.trials;
  row_.time_s = elapsed();
}

IpoptSolver::Stop IpoptSolver::reason_to_stop(const InteriorPointIterate& iterate) const {
  if (options_.interrupted && options_.interrupted()) return Stop::interrupted;
  if (elapsed() >= options_.max_time_s) return Stop::time_limit;
  if (leaves_chart(iterate)) return Stop::recenter;
  return cost_settled() ? Stop::cost_settled : Stop::none;
}

/// True if another run should continue from here with the iterate as the new center.
bool IpoptSolver::leaves_chart(const InteriorPointIterate& iterate) const {
  return !iterate.restoration && row_.iteration < options_.max_iterations &&
         transcription_->chart_angle() > tuning::kLargestAngle;
}

/// True if Ipopt's iterate is feasible and its cost has settled to the caller's tolerance. With
/// relaxed pairs, the cost is that of another problem.
bool IpoptSolver::cost_settled() const {
  return cost_has_settled(result_.log, options_.tolerances.cost_decrease) &&
         !transcription_->has_pairs() && is_feasible(row_, options_.tolerances);
}

/// Logs the iterate of Newton's method.
void IpoptSolver::record() {
  newton_.describe(row_);
  row_.time_s = elapsed();
  result_.log.push_back(row_);
  if (options_.on_iteration) options_.on_iteration(row_);
}

/// The gains belong to a sweep at the previous iterate. If only controls are bounded, they belong
/// to no sweep: active controls are stiff penalties in them.
void IpoptSolver::note_newton_step() {
  gain_regularization_.reset();
  if (!problem_.constraints().empty()) gain_regularization_ = 0;
  ++row_.newton;
  ++row_.iteration;
  record();
  consider();
}

/// Makes the Newton iterate the answer if it is better than the answer so far.
void IpoptSolver::consider(bool preferred) {
  if (!choice_.take(newton_.norms(), preferred)) return;
  answer_row_ = row_;
  newton_.describe(answer_row_);
  write_result();
}

/// Last row of the log, if it describes the answer. The log is empty without iterations, for
/// example if Ipopt finds more equations than variables.
IterationRecord* IpoptSolver::row_of_answer() {
  if (result_.log.empty()) return nullptr;
  IterationRecord& last = result_.log.back();
  const bool same = last.cost == answer_row_.cost && last.newton == answer_row_.newton;
  return same ? &last : nullptr;
}

/// Makes the row of the answer the last row of the log.
void IpoptSolver::log_answer() {
  if (!choice_.has_answer() || !std::isfinite(answer_row_.cost)) return;
  if (IterationRecord* const last = row_of_answer()) {
    // Stationarity along the answer's gains differs from that along the gains of the last step.
    // Controls that Ipopt left outside their bounds by rounding are now inside.
    last->stationarity = answer_row_.stationarity;
    last->stationarity_knot = answer_row_.stationarity_knot;
    last->gap = answer_row_.gap;
    last->gap_knot = answer_row_.gap_knot;
    last->constraint = answer_row_.constraint;
    last->constraint_knot = answer_row_.constraint_knot;
    return;
  }
  // Counters continue from the current row.
  answer_row_.iteration = row_.iteration;
  answer_row_.outer = row_.outer;
  answer_row_.newton = row_.newton;
  answer_row_.time_s = elapsed();
  result_.log.push_back(answer_row_);
  if (options_.on_iteration) options_.on_iteration(answer_row_);
}

void IpoptSolver::write_result() {
  result_.feedback_regularization.reset();
  if (const auto where = find_non_finite(newton_.linearization())) {
    result_.failed_knot = where->knot;
    result_.failed_quantity = where->quantity;
    write_values();
    return;
  }
  result_.feedback_regularization = gain_regularization_;
  newton_.write_answer(result_);
}

/// Writes the values of an answer whose derivatives are not finite.
void IpoptSolver::write_values() {
  result_.trajectory = newton_.trajectory();
  Evaluation values(problem_);
  evaluator_.evaluate(result_.trajectory, values);
  const Extremum violation =
      largest_violation(problem_, bounds_, result_.trajectory, values.constraint);
  result_.constraint_values = values.constraint;
  result_.cost = values.cost.sum() + linear_soft_cost(problem_, values.constraint);
  result_.residuals = {.gap = values.gap.size() == 0 ? 0 : values.gap.cwiseAbs().maxCoeff(),
                       .constraint = violation.value,
                       .constraint_knot = violation.knot};
  answer_row_.cost = answer_row_.merit = result_.cost;
  answer_row_.stationarity = result_.residuals.stationarity;
  answer_row_.gap = result_.residuals.gap;
  answer_row_.constraint = violation.value;
  answer_row_.constraint_knot = violation.knot;
}

bool IpoptSolver::under_tolerances(const KktNorms& norms) const {
  return AnswerChoice::excess(norms, options_.tolerances) <= 1;
}

void IpoptSolver::set_status(const InteriorPointAnswer& answer) {
  const auto [status, message] = find_status(answer);
  result_.status = status;
  result_.message = fmt::format("{}: {}", message, residual_text());
}

IpoptSolver::Ending IpoptSolver::find_status(const InteriorPointAnswer& answer) const {
  if (choice_.is_solution()) return {SolveStatus::converged, "all residuals are under tolerance"};
  if (auto stopped = stopped_status()) return *std::move(stopped);
  if (iterations_used_up(answer))
    return {SolveStatus::max_iterations,
            fmt::format("not converged after {} iterations", row_.iteration)};
  if (!answer.is_good()) return {status_of(answer.end), "Ipopt: " + answer.message};
  if (start_violates_constraint())
    return {SolveStatus::infeasible, "the initial state itself violates a constraint"};
  return {status_of(answer.end), "Ipopt: " + answer.message + ", but not all of this solve's"};
}

/// Status of a solve that the callback ended.
std::optional<IpoptSolver::Ending> IpoptSolver::stopped_status() const {
  if (stop_ == Stop::cost_settled && is_feasible(result_.residuals, options_.tolerances))
    return Ending{SolveStatus::cost_settled, "the cost has settled"};
  if (stop_ == Stop::interrupted) return Ending{SolveStatus::interrupted, "interrupted"};
  if (stop_ == Stop::time_limit) return Ending{SolveStatus::time_limit, "the time is up"};
  return std::nullopt;
}

bool IpoptSolver::iterations_used_up(const InteriorPointAnswer& answer) const {
  return answer.end == End::max_iterations ||
         (answer.is_good() && row_.iteration >= options_.max_iterations);
}

/// Constraints on given parts of the first state are not rows of the program.
bool IpoptSolver::start_violates_constraint() const {
  return result_.residuals.constraint > options_.tolerances.constraint &&
         result_.residuals.constraint_knot >= 0 &&
         transcription_->has_given_constraints(result_.residuals.constraint_knot);
}

std::string IpoptSolver::residual_text() const {
  const auto at = [](int knot) { return knot < 0 ? "" : fmt::format(" (knot {})", knot); };
  const Residuals& r = result_.residuals;
  return fmt::format(
      "stationarity {:.1e}{}, gap {:.1e}{}, constraint violation {:.1e}{}, complementarity {:.1e}",
      r.stationarity, at(r.stationarity_knot), r.gap, at(r.gap_knot), r.constraint,
      at(r.constraint_knot), r.complementarity);
}

double IpoptSolver::elapsed() const { return seconds_since(began_); }

}  // namespace conddp
