#include "solvers/ddp_solver.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "solvers/finite_check.hpp"

namespace conddp {
namespace {

using Clock = std::chrono::steady_clock;

/// Adds the time until its end to a sum of seconds.
class Stopwatch {
 public:
  explicit Stopwatch(double& sum) : sum_(sum), began_(Clock::now()) {}
  ~Stopwatch() { sum_ += std::chrono::duration<double>(Clock::now() - began_).count(); }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double& sum_;
  Clock::time_point began_;
};

/// Shortest step that is tried where stationarity has to judge it, and the share to which it has
/// to fall.
constexpr double kShortestBlindStep = 1.0 / 16;
constexpr double kBlindProgress = 0.999;
/// Minimisations of an augmented Lagrangian end early: at a stationarity and a relative decrease of
/// the merit that get smaller from one to the next.
constexpr double kFirstInnerTolerance = 1e-1, kFirstInnerDecrease = 1e-3;
/// A short step's small decrease says nothing.
constexpr double kLongStep = 0.1;
/// Minimisations that may end without a step before the solve does.
constexpr int kRecoveries = 20;
constexpr double kTighter = 0.1, kLastInnerDecrease = 1e-8;
/// Violation, gap and stationarity below which the projected Newton method is tried, how much
/// smaller they have to be after it failed, and its steps at most.
constexpr double kFirstNewtonThreshold = 3e-3, kNextNewtonThreshold = 0.1;
constexpr int kNewtonSteps = 20, kDampedNewtonSteps = 2;
constexpr double kNewtonGoal = 1e-12;
/// Shares of the expected decrease that a model step has to reach, and that its gaps, weighted by
/// their multipliers, may reach.
constexpr double kModelStepDecrease = 0.1;
constexpr double kModelStepGaps = 0.5;
/// Shares of the expected decrease between which a full step is one of a quadratic function: ½ of
/// the decrease at first is what a perfect model would give.
constexpr double kQuadraticFrom = 0.3, kQuadraticTo = 0.8;
/// Share of the gaps' weight in the merit that pays for what the model's step costs.
constexpr double kGapShare = 0.7;
/// Rows of the log that are reserved at most before the first iteration.
constexpr int kReservedRows = 10000;

void check_shape(const ShootingProblem& problem, const Trajectory& guess) {
  bool fits = guess.knots() == problem.knots() && guess.nx() == problem.nx();
  for (int k = 0; fits && k < problem.knots(); ++k) fits = guess.nu(k) == problem.nu(k);
  if (!fits) throw std::invalid_argument("the guess does not have the shape of the problem");
}

/// Puts the quaternions of the guess' states on the unit sphere.
void normalize_states(const ShootingProblem& problem, Trajectory& trajectory) {
  for (int k = 0; k <= problem.knots(); ++k) {
    if (trajectory.x(k).allFinite() && !problem.manifold().normalize(trajectory.x(k).data())) {
      throw std::invalid_argument(
          fmt::format("state {} of the guess: a quaternion is far from unit length", k));
    }
  }
}

}  // namespace

DdpSolver::DdpSolver(const ShootingProblem& problem, const DdpRecipe& recipe,
                     const SolverOptions& options)
    : problem_(problem),
      recipe_(recipe),
      options_(options),
      bounds_(problem),
      acts_(problem, options.threads),
      linearization_(problem),
      hessian_(recipe.hessian, options.tolerances.stationarity, acts_, linearization_),
      gaps_(problem),
      adjoint_(problem, bounds_),
      direction_(problem, bounds_,
                 {.clamp_controls = recipe.clamp_controls, .box_stage = recipe.box_stage},
                 options.box_qp),
      line_search_(problem, options.line_search),
      regularization_(options.regularization),
      trajectory_(problem.create_trajectory()),
      before_(problem.create_trajectory()),
      result_(problem) {
  if (!recipe.constraints || problem.constraints().empty()) return;
  constraints_.emplace(problem, options);
  augmentation_ = &constraints_->augmentation();
  if (recipe.newton) newton_.emplace(problem, acts_);
}

SolveResult DdpSolver::solve(const Trajectory& guess) {
  began_ = Clock::now();
  check_shape(problem_, guess);
  result_ = SolveResult(problem_);
  result_.log.reserve(std::min(options_.max_iterations, kReservedRows) + 1);
  regularization_ = RegularizationSchedule(options_.regularization);
  row_ = IterationRecord();
  direction_.reset();
  search_ = LineSearchResult();
  merit_ = MeritModel();
  linearized_ = false;
  at_rounding_floor_ = false;
  full_steps_ = 0;
  full_steps_wanted_ = 1;
  hessian_.reset();
  inner_tolerance_ = kFirstInnerTolerance;
  inner_decrease_ = kFirstInnerDecrease;
  inner_start_ = recoveries_ = 0;
  newton_threshold_ = kFirstNewtonThreshold;
  by_newton_ = false;
  if (constraints_) constraints_->start(result_.constraint_multipliers);

  if (start(guess)) {
    while (linearize() && !converged() && may_continue() && (take_step() || recover()))
      ++row_.iteration;
    finish();
  }
  result_.iterations = row_.iteration;
  result_.times.total = elapsed();
  return std::move(result_);
}

/// Where the first iteration starts. With closed gaps the states follow from the controls.
bool DdpSolver::start(const Trajectory& guess) {
  trajectory_ = guess;
  const int clamped = recipe_.clamp_controls ? bounds_.clamp(trajectory_) : 0;
  result_.start = recipe_.open_gaps ? "states and controls of the guess"
                                    : "controls of the guess, simulated from the initial state";
  if (clamped > 0) {
    result_.start += fmt::format("; {} control {} moved to a bound", clamped,
                                 clamped == 1 ? "entry" : "entries");
  }
  const Eigen::Map<const Eigen::VectorXd> x0(problem_.initial_state().data(), problem_.nx());
  if (recipe_.open_gaps) {
    const double off = (trajectory_.x(0) - x0).lpNorm<Eigen::Infinity>();
    if (off != 0) result_.start += fmt::format("; x_0 corrected by {:.2g}", off);
    trajectory_.x(0) = x0;
    normalize_states(problem_, trajectory_);
    return true;
  }
  const Stopwatch watch(result_.times.evaluate);
  const int bad_knot = acts_.simulate(trajectory_);
  if (bad_knot < 0) return true;
  result_.trajectory = guess;
  result_.failed_knot = bad_knot;
  result_.failed_quantity = "cost or next state";
  return end(SolveStatus::diverged,
             fmt::format("simulating the controls of the guess gives a cost or next state that is "
                         "not finite at knot {}",
                         bad_knot));
}

/// Derivatives and residuals of the iterate, and its row in the log.
bool DdpSolver::linearize() {
  if (!linearized_) differentiate();
  if (!linearized_) return end_diverged();
  row_.cost = linearization_.total_cost();
  merit_.cost = row_.cost + linearization_.augmentation.sum();
  merit_.gap_norm = gaps_.norm();
  merit_.rounding = adjoint_.cost_rounding(linearization_, trajectory_);
  row_.merit = merit_.value();
  const Extremum stationarity = bounds_.projected_norm(adjoint_.gradient(), trajectory_);
  last_stationarity_ = row_.stationarity;
  row_.stationarity = stationarity.value;
  row_.stationarity_knot = stationarity.knot;
  row_.gap = linearization_.max_gap();
  row_.gap_knot = -1;
  if (row_.gap > 0) {
    Eigen::Index row = 0, column = 0;
    linearization_.gap.cwiseAbs().maxCoeff(&row, &column);
    row_.gap_knot = static_cast<int>(column);
  }
  measure_constraints();
  row_.time_s = elapsed();
  hessian_.watch(row_);
  result_.log.push_back(row_);
  if (options_.on_iteration) options_.on_iteration(row_);
  return true;
}

bool DdpSolver::converged() {
  const auto& tolerance = options_.tolerances;
  if (row_.stationarity <= tolerance.stationarity && row_.gap <= tolerance.gap &&
      row_.constraint <= tolerance.constraint &&
      row_.complementarity <= tolerance.complementarity) {
    end(SolveStatus::converged, residual_text());
    return true;
  }
  if (!constraints_) return false;
  if (newton_converges()) {
    end(SolveStatus::converged, residual_text());
    return true;
  }
  if (!linearized_) return !end_diverged();
  return inner_converged() && !next_multipliers();
}

void DdpSolver::measure_constraints() {
  const Extremum bounds = bounds_.violation(trajectory_);
  row_.constraint = bounds.value;
  row_.constraint_knot = bounds.knot;
  if (!constraints_) return;
  const ConstraintNorms norms = constraints_->measure(linearization_.constraint);
  if (!(norms.violation.value <= row_.constraint)) {
    row_.constraint = norms.violation.value;
    row_.constraint_knot = norms.violation.knot;
  }
  row_.complementarity = norms.complementarity;
  row_.constraint_penalty = constraints_->largest_penalty();
}

/// Whether the augmented Lagrangian is minimised well enough for better multipliers.
bool DdpSolver::inner_converged() const {
  if (row_.gap > std::max(options_.tolerances.gap, 1e-2 * row_.constraint)) return false;
  if (row_.stationarity <= std::max(inner_tolerance_, options_.tolerances.stationarity))
    return true;
  return row_.iteration > inner_start_ && row_.step >= kLongStep &&
         row_.actual_decrease <= inner_decrease_ * std::abs(merit_.cost);
}

/// Ends a minimisation of the augmented Lagrangian and begins the next at the same iterate. False
/// where the solve ends.
bool DdpSolver::next_multipliers() {
  constraints_->update();
  if (!constraints_->hopeless().empty()) {
    return end(SolveStatus::infeasible,
               fmt::format("the constraint '{}' is violated whatever its penalty: {}",
                           constraints_->hopeless(), residual_text()));
  }
  ++row_.outer;
  inner_tolerance_ *= kTighter;
  inner_decrease_ = std::max(kTighter * inner_decrease_, kLastInnerDecrease);
  inner_start_ = row_.iteration;
  at_rounding_floor_ = false;
  regularization_ = RegularizationSchedule(options_.regularization);
  differentiate();
  if (!linearized_) return end_diverged();
  merit_.cost = linearization_.total_cost() + linearization_.augmentation.sum();
  row_.stationarity = bounds_.projected_norm(adjoint_.gradient(), trajectory_).value;
  return true;
}

/// Where a minimisation gets no further, other multipliers and penalties may.
bool DdpSolver::recover() {
  const bool stuck = result_.status == SolveStatus::line_search_failed ||
                     result_.status == SolveStatus::regularization_limit;
  if (!constraints_ || !stuck || row_.constraint <= options_.tolerances.constraint) return false;
  return ++recoveries_ <= kRecoveries && next_multipliers();
}

/// Tries to end the solve by Newton's method on the active constraints. Its steps are iterations,
/// and where it fails the iterate before them stands.
bool DdpSolver::newton_converges() {
  if (!newton_ || std::max({row_.stationarity, row_.gap, row_.constraint}) > newton_threshold_)
    return false;
  const IterationRecord row = row_;
  newton_->start(trajectory_, constraints_->multipliers(), augmentation_->penalty,
                 direction_.feedback());
  const auto& tolerance = options_.tolerances;
  int damped = 0;
  for (int i = 0; i < kNewtonSteps && row_.iteration < options_.max_iterations; ++i) {
    if (newton_->norms().largest() <= kNewtonGoal || !newton_->step()) break;
    const KktNorms& norms = newton_->norms();
    ++row_.iteration;
    ++row_.newton;
    row_.cost = row_.merit = newton_->cost();
    row_.stationarity = norms.stationarity.value;
    row_.stationarity_knot = norms.stationarity.knot;
    row_.gap = norms.gap.value;
    row_.gap_knot = norms.gap.knot;
    row_.constraint = norms.violation.value;
    row_.constraint_knot = norms.violation.knot;
    row_.complementarity = norms.complementarity;
    row_.step = newton_->step_length();
    row_.active_rows = newton_->active_rows();
    row_.regularization = row_.expected_decrease = row_.actual_decrease = 0;
    row_.trials = row_.clamped_controls = row_.active_set_changes = 0;
    row_.time_s = elapsed();
    result_.log.push_back(row_);
    if (options_.on_iteration) options_.on_iteration(row_);
    damped += newton_->step_length() < 1;
    if (damped > kDampedNewtonSteps) break;
  }
  newton_threshold_ = kNextNewtonThreshold * std::max({row.stationarity, row.gap, row.constraint});
  if (newton_->norms().stationarity.value > tolerance.stationarity ||
      newton_->norms().gap.value > tolerance.gap ||
      newton_->norms().violation.value > tolerance.constraint) {
    const int iteration = row_.iteration;
    const int newton = row_.newton;
    row_ = row;
    row_.iteration = iteration;
    row_.newton = newton;
    return false;
  }
  before_ = trajectory_;
  trajectory_ = newton_->trajectory();
  constraints_->adopt(newton_->multipliers());
  differentiate();
  if (!linearized_) return false;
  row_.cost = linearization_.total_cost();
  row_.stationarity = bounds_.projected_norm(adjoint_.gradient(), trajectory_).value;
  measure_constraints();
  by_newton_ = row_.stationarity <= tolerance.stationarity &&
               row_.complementarity <= tolerance.complementarity;
  return by_newton_;
}

bool DdpSolver::may_continue() {
  if (row_.iteration >= options_.max_iterations) {
    return end(SolveStatus::max_iterations, fmt::format("not converged after {} iterations: {}",
                                                        row_.iteration, residual_text()));
  }
  return budget_left();
}

bool DdpSolver::budget_left() {
  if (options_.interrupted && options_.interrupted()) {
    return end(SolveStatus::interrupted, fmt::format("interrupted: {}", residual_text()));
  }
  if (elapsed() >= options_.max_time_s) {
    return end(SolveStatus::time_limit,
               fmt::format("not converged within {} s: {}", options_.max_time_s, residual_text()));
  }
  return true;
}

/// Sweeps and searches, with more regularisation after every failure, until a step is accepted.
bool DdpSolver::take_step() {
  row_.trials = 0;
  for (;;) {
    if (!sweep_with_regularization()) return false;
    correct_direction();
    measure_direction();
    bool descent = merit_.descends();
    if (model_step() || (descent && search())) break;
    if (direction_.corrected()) {
      at_rounding_floor_ = false;
      direction_.undo_correction(linearization_, trajectory_, gaps_);
      measure_direction();
      descent = merit_.descends();
      if (descent && search()) break;
    }
    if (at_rounding_floor_) {
      // Exact Hessians take the last digits in one step where Gauss-Newton creeps.
      if (hessian_.turn()) {
        at_rounding_floor_ = false;
        differentiate();
        continue;
      }
      result_.failed_quantity = kRoundedCost;
      return end(SolveStatus::line_search_failed,
                 fmt::format("the cost's rounding ({:.1e}) hides what is left to gain, and the "
                             "stationarity does not fall any more: {}",
                             merit_.rounding, residual_text()));
    }
    if (!regularization_.increase()) return end_without_step(descent);
    if (!budget_left()) return false;
  }
  const double share = search_.actual_decrease / search_.expected_decrease;
  const bool quadratic = merit_.hidden(search_.expected_decrease) ||
                         (share >= kQuadraticFrom && share <= kQuadraticTo);
  if (search_.step == 1 && direction_.within_bounds() && quadratic) {
    direction_.step_taken();
  } else {
    direction_.forget_steps();
  }
  full_steps_ = search_.step == 1 && quadratic ? full_steps_ + 1 : 0;
  row_.step = search_.step;
  row_.expected_decrease = search_.expected_decrease;
  row_.actual_decrease = search_.actual_decrease;
  row_.regularization = regularization_.value();
  row_.penalty = merit_.penalty;
  row_.exact_hessian = hessian_.exact_in_use();
  row_.clamped_controls = direction_.policy().clamped_controls();
  row_.active_set_changes = direction_.policy().active_set_changes();
  if (search_.step >= options_.regularization.decrease_step) {
    regularization_.decrease();
  } else if (search_.step <= options_.regularization.increase_step) {
    regularization_.increase();
  }
  return true;
}

/// Gauss-Newton's steps learn from each other, where the Hessian is not to be just that.
void DdpSolver::correct_direction() {
  const Stopwatch watch(result_.times.sweep);
  if (recipe_.hessian == HessianUse::when_slow && !constraints_ && !hessian_.exact_in_use() &&
      regularization_.value() == 0) {
    direction_.correct(linearization_, trajectory_, gaps_);
  } else {
    direction_.forget_steps();
  }
}

/// The full step of the linear model, judged when it is linearised, which the next iteration needs
/// anyway: as long as full steps go well that saves the rollout. Its gaps are of second order. They
/// are judged by what closing them will cost, to first order Σ λᵀ gap: the merit's ν Σ‖gap‖₁ would
/// reject good steps near the optimum (Maratos' effect).
bool DdpSolver::model_step() {
  if (!recipe_.open_gaps || constraints_ || !direction_.within_bounds() ||
      hessian_.exact_wanted() || regularization_.value() > 0 || full_steps_ < full_steps_wanted_) {
    return false;
  }
  // The step that should be the last one closes the gaps.
  if (row_.stationarity * row_.stationarity <=
      options_.tolerances.stationarity * last_stationarity_) {
    return false;
  }
  before_ = trajectory_;
  const double closed_cost = merit_.cost + adjoint_.gap_slope();
  const double expected = adjoint_.gap_slope() - merit_.slope;
  direction_.step().apply(problem_.manifold(), trajectory_);
  bounds_.clamp(trajectory_);  // rounding
  ++row_.trials;
  differentiate();
  const double actual = closed_cost - linearization_.total_cost() - adjoint_.gap_slope();
  const bool accepted =
      linearized_ &&
      (merit_.hidden(expected)
           ? merit_.hidden(actual) && projected_stationarity() < kBlindProgress * row_.stationarity
           : actual >= kModelStepDecrease * expected && gap_weight() <= kModelStepGaps * expected);
  if (accepted) {
    search_ = {.accepted = true,
               .step = 1,
               .expected_decrease = expected,
               .actual_decrease = actual,
               .trials = 1};
    return true;
  }
  full_steps_wanted_ *= 2;
  full_steps_ = 0;
  trajectory_ = before_;
  differentiate();
  return false;
}

/// Σ|λᵢ gapᵢ| of the iterate.
double DdpSolver::gap_weight() const {
  return adjoint_.costates()
      .rightCols(problem_.knots())
      .cwiseProduct(linearization_.gap)
      .lpNorm<1>();
}

double DdpSolver::projected_stationarity() const {
  return bounds_.projected_norm(adjoint_.gradient(), trajectory_).value;
}

/// Line search along the sweep's policy. A step that the merit is too coarse to judge counts only
/// if stationarity falls.
bool DdpSolver::search() {
  before_ = trajectory_;
  for (double first_step = 1; first_step >= kShortestBlindStep; first_step /= 2) {
    {
      const Stopwatch watch(result_.times.rollout);
      search_ = line_search_.run(acts_, merit_, adjoint_, linearization_.gap, direction_.feedback(),
                                 {.contract_gaps = recipe_.open_gaps,
                                  .clamp_controls = recipe_.clamp_controls,
                                  .augmentation = augmentation_},
                                 first_step, trajectory_);
    }
    row_.trials += search_.trials;
    if (!search_.accepted) return false;
    linearized_ = false;
    if (!search_.by_rounding || stationarity_fell()) return true;
    trajectory_ = before_;
    differentiate();
  }
  at_rounding_floor_ = true;
  return false;
}

bool DdpSolver::stationarity_fell() {
  differentiate();
  return linearized_ && projected_stationarity() < kBlindProgress * row_.stationarity;
}

bool DdpSolver::sweep_with_regularization() {
  const Stopwatch watch(result_.times.sweep);
  for (;;) {
    const int bad_knot = sweep_backward(regularization_.value());
    if (bad_knot < 0) return true;
    if (find_non_finite(linearization_)) return end_diverged();
    if (!regularization_.increase()) {
      result_.failed_knot = bad_knot;
      result_.failed_quantity = "Q_uu";
      return end(SolveStatus::regularization_limit,
                 fmt::format("Q_uu at knot {} is not positive definite with the largest "
                             "regularisation {:.1e}: {}",
                             bad_knot, regularization_.value(), residual_text()));
    }
    if (!budget_left()) return false;
  }
}

/// Returns the knot whose stage has no minimum, or −1. Exact Hessians may be indefinite far from an
/// optimum; then the Gauss-Newton ones, which keep the costs' curvature and have the problem's own
/// scaling, make a better convex model than any multiple of the identity.
int DdpSolver::sweep_backward(double regularization) {
  for (bool exact : {true, false}) {
    if (exact && !hessian_.exact_known()) continue;
    hessian_.use(exact);
    const int bad_knot = direction_.find(linearization_, trajectory_, gaps_, adjoint_, merit_,
                                         {options_.regularization.kind, regularization});
    if (bad_knot < 0 || !exact) return bad_knot;
  }
  return -1;
}

/// Derivatives and co-states of the iterate; linearized_ tells whether they are finite.
void DdpSolver::differentiate() {
  const Stopwatch watch(result_.times.differentiate);
  hessian_.begin_iterate();
  acts_.differentiate(trajectory_, linearization_, augmentation_);
  gaps_.set(linearization_, recipe_.open_gaps);
  adjoint_.compute(linearization_, trajectory_, gaps_, direction_.feedback());
  linearized_ = std::isfinite(linearization_.total_cost()) &&
                std::isfinite(linearization_.augmentation.sum()) &&
                linearization_.gap.allFinite() && adjoint_.costates().allFinite() &&
                adjoint_.gradient().allFinite();
  const bool closed = !recipe_.open_gaps || linearization_.max_gap() <= options_.tolerances.gap;
  if (hessian_.exact_wanted() && linearized_ && closed) {
    hessian_.evaluate_exact(trajectory_, adjoint_.costates(), augmentation_);
  }
}

/// The model's view of the full step; the weight of the gaps is kept above its multipliers.
void DdpSolver::measure_direction() {
  const Stopwatch watch(result_.times.sweep);
  merit_.slope = direction_.step().slope();
  merit_.slope_within_bounds = direction_.within_bounds();
  // Co-states without gains say little of the cost's rounding.
  if (row_.iteration == 0 || !merit_.slope_within_bounds) {
    adjoint_.compute(linearization_, trajectory_, gaps_, direction_.feedback());
    merit_.rounding = adjoint_.cost_rounding(linearization_, trajectory_);
  }
  if (!recipe_.open_gaps) return;
  if (!gaps_.closed() && !merit_.slope_within_bounds && merit_.penalty > 0) {
    // Without a settled active set the policy's value says nothing of the QP's multipliers: the
    // weight stays what it was, or grows until it turns the model's step into descent (Nocedal,
    // Wright, equation 18.36).
    const double model = merit_.slope + 0.5 * std::max(direction_.curvature(linearization_), 0.0);
    merit_.penalty = std::max(merit_.penalty, model / (kGapShare * merit_.gap_norm));
    return;
  }
  const double multiplier =
      gaps_.closed() ? adjoint_.costates().lpNorm<Eigen::Infinity>() : direction_.multiplier();
  merit_.penalty = options_.line_search.merit_margin * multiplier;
}

/// Residuals, co-states and gains of the iterate that is returned.
void DdpSolver::finish() {
  if (!linearized_) differentiate();
  result_.trajectory = trajectory_;
  if (find_non_finite(linearization_)) return;
  result_.cost = linearization_.total_cost();
  Residuals& residuals = result_.residuals;
  const Extremum stationarity = bounds_.projected_norm(adjoint_.gradient(), trajectory_);
  residuals.stationarity = stationarity.value;
  residuals.stationarity_knot = stationarity.knot;
  residuals.gap = 0;
  for (int k = 0; k < problem_.knots(); ++k) {
    const double gap = linearization_.gap.col(k).lpNorm<Eigen::Infinity>();
    if (gap <= residuals.gap) continue;
    residuals.gap = gap;
    residuals.gap_knot = k;
  }
  measure_constraints();
  residuals.constraint = row_.constraint;
  residuals.constraint_knot = row_.constraint_knot;
  residuals.complementarity = row_.complementarity;
  if (constraints_) {
    result_.constraint_values = linearization_.constraint;
    result_.constraint_multipliers = constraints_->multipliers();
  }
  confirm_status();
  result_.costates = adjoint_.costates();
  result_.state_gradient = adjoint_.state_gradient();
  for (int k = 0; k < problem_.knots(); ++k) {
    result_.control_gradient.push_back(
        adjoint_.gradient().segment(bounds_.offset(k), problem_.nu(k)));
  }
  if (by_newton_) {
    result_.feedback = newton_->feedback();
    result_.feedback_regularization = 0;
    return;
  }
  sweep_for_gains();
}

/// The co-states of the last sweep may put an answer under tolerance that ended otherwise.
void DdpSolver::confirm_status() {
  const Residuals& r = result_.residuals;
  const auto& tolerance = options_.tolerances;
  if (r.stationarity > tolerance.stationarity || r.gap > tolerance.gap ||
      r.constraint > tolerance.constraint) {
    return;
  }
  if (result_.status == SolveStatus::converged) return;
  result_.failed_knot = -1;
  result_.failed_quantity.clear();
  end(SolveStatus::converged,
      fmt::format("at the end, all residuals are under tolerance: stationarity {:.1e}, gap {:.1e}, "
                  "constraint violation {:.1e}",
                  r.stationarity, r.gap, r.constraint));
}

/// Without regularisation if possible: a follower of the trajectory wants the true gains.
void DdpSolver::sweep_for_gains() {
  const Stopwatch watch(result_.times.sweep);
  SolverOptions::Regularization from_zero = options_.regularization;
  from_zero.initial = 0;
  RegularizationSchedule schedule(from_zero);
  do {
    if (sweep_backward(schedule.value()) < 0) {
      result_.feedback = direction_.feedback();
      result_.feedback_regularization = schedule.value();
      return;
    }
  } while (schedule.increase());
}

bool DdpSolver::end(SolveStatus status, std::string message) {
  result_.status = status;
  result_.message = std::move(message);
  return false;
}

bool DdpSolver::end_diverged() {
  const NonFinite where = find_non_finite(linearization_).value_or(NonFinite{0, "co-state"});
  const bool first = row_.iteration == 0;
  if (!first) trajectory_ = before_;
  linearized_ = false;
  result_.failed_knot = where.knot;
  result_.failed_quantity = where.quantity;
  return end(SolveStatus::diverged,
             fmt::format("the {} of knot {} is not finite {}", where.quantity, where.knot,
                         first ? "at the start" : "after the last step, which is taken back"));
}

bool DdpSolver::end_without_step(bool descent) {
  std::string cause;
  if (!descent) {
    cause = fmt::format("the direction does not descend (slope {:.1e})", merit_.merit_slope());
  } else {
    cause = fmt::format("no step length down to {:.1e} lowers the merit (slope {:.1e})",
                        options_.line_search.min_step, merit_.merit_slope());
    if (search_.first_bad_knot >= 0) {
      result_.failed_knot = search_.first_bad_knot;
      result_.failed_quantity = "motion";
      cause += fmt::format(", and longer ones leave the finite numbers at knot {}",
                           search_.first_bad_knot);
    }
  }
  return end(SolveStatus::line_search_failed,
             fmt::format("{} with the largest regularisation {:.1e}: {}", cause,
                         regularization_.value(), residual_text()));
}

std::string DdpSolver::residual_text() const {
  const auto at = [](int knot) { return knot < 0 ? "" : fmt::format(" (knot {})", knot); };
  std::string text =
      fmt::format("stationarity {:.1e}{}", row_.stationarity, at(row_.stationarity_knot));
  text += fmt::format(", gap {:.1e}{}", row_.gap, at(row_.gap_knot));
  text += fmt::format(", constraint violation {:.1e}", row_.constraint);
  if (constraints_) {
    text += at(row_.constraint_knot);
    text += fmt::format(", complementarity {:.1e}", row_.complementarity);
  }
  return text;
}

double DdpSolver::elapsed() const {
  return std::chrono::duration<double>(Clock::now() - began_).count();
}

}  // namespace conddp
