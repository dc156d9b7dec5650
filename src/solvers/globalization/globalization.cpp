#include "solvers/globalization/globalization.hpp"

#include <string>

#include <fmt/format.h>

#include "base/stopwatch.hpp"
#include "solvers/common/finite_check.hpp"

namespace conddp {
namespace {

/// Shortest step tried when stationarity must judge it, and the factor by which stationarity must
/// shrink.
constexpr double kShortestBlindStep = 1.0 / 16;
constexpr double kBlindProgress = 0.999;
/// Range of the actual decrease, as a share of the expected one, for a full step of a quadratic
/// function. A perfect model gives ½ of the first-order decrease.
constexpr double kQuadraticFrom = 0.3, kQuadraticTo = 0.8;
/// Largest regularization in the search for a direction with a settled active set.
constexpr double kSettlingRegularization = 0.01;
/// Upper limit of the smallest regularization, in multiples of the costs' curvature in the
/// controls.
constexpr double kCurvatures = 2;
/// The regularization falls after a step at least as long as the first and rises after one at most
/// as long as the second. Between them, its model is about right.
constexpr double kLongStep = 0.5, kShortStep = 0.2;
/// Weight in the merit of gaps that a step opens, as a multiple of the largest multiplier. Above 1,
/// the penalty is exact (Nocedal, Wright 2006, theorem 17.3).
constexpr double kMeritMargin = 1.5;

}  // namespace

Globalization::Globalization(const ShootingProblem& problem, const ControlBounds& bounds,
                             const DdpRecipe& recipe, const SolverOptions& options,
                             Iterate& iterate, OuterStrategy& outer, SolveRecord& record)
    : problem_(problem),
      recipe_(recipe),
      options_(options),
      iterate_(iterate),
      outer_(outer),
      record_(record),
      direction_(problem, bounds,
                 {.clamp_controls = recipe.clamp_controls,
                  .box_stage = recipe.box_stage,
                  .null_space = recipe.multipliers == MultiplierSchedule::by_the_sweep &&
                                !problem.constraints().empty()}),
      line_search_(problem),
      open_gap_search_(problem, bounds, recipe.clamp_controls),
      full_step_search_(problem, bounds, options.tolerances),
      control_curvature_(problem),
      regularization_(options.regularization.initial) {
  if (direction_.qp().has_rows()) affine_probe_.emplace(problem);
  if (outer.augmentation() != nullptr && direction_.null_space() != nullptr)
    equality_search_.emplace(problem);
}

void Globalization::reset(int sweeps) {
  regularization_ = RegularizationSchedule(options_.regularization.initial);
  direction_.reset(sweeps);
  line_search_.reset();
  full_step_search_.reset();
  search_ = LineSearchResult();
  merit_ = MeritModel();
  affine_known_ = at_rounding_floor_ = false;
  last_stationarity_ = 0;
}

void Globalization::measure() {
  merit_.cost = iterate_.linearization.total_cost();
  if (equality_search_) {
    merit_.gap_norm = equality_search_->infeasibility(iterate_.linearization.gap,
                                                      iterate_.linearization.constraint);
  } else {
    merit_.cost += iterate_.linearization.augmentation.sum();
    merit_.gap_norm = iterate_.gaps.norm();
  }
  merit_.rounding = iterate_.adjoint.cost_rounding(iterate_.linearization, iterate_.trajectory);
  record_.row.merit = merit_.value();
}

void Globalization::begin_minimization() {
  at_rounding_floor_ = false;
  regularization_ = RegularizationSchedule(options_.regularization.initial);
  merit_.cost = iterate_.linearization.total_cost() + iterate_.linearization.augmentation.sum();
}

bool Globalization::gaps_open() const {
  return recipe_.open_gaps && !equality_search_ && iterate_.gaps.norm() > options_.tolerances.gap;
}

/// Sweeps and searches, with more regularization after every failure, until a step is accepted.
bool Globalization::step() {
  IterationRecord& row = record_.row;
  row.trials = 0;
  const int sweeps_before = direction_.qp().sweeps();
  bool by_full_step = false;
  if (!find_step(by_full_step)) return false;
  step_taken(by_full_step);
  row.sweeps = direction_.qp().sweeps() - sweeps_before;
  row.step = search_.step;
  row.expected_decrease = search_.expected_decrease;
  row.actual_decrease = search_.actual_decrease;
  row.regularization = regularization_.value();
  row.penalty = merit_.penalty;
  row.exact_hessian = iterate_.hessian.exact_in_use();
  row.clamped_controls = direction_.qp().active_set().clamped_controls();
  row.active_set_changes = direction_.qp().active_set().changes();
  if (search_.step >= kLongStep) {
    regularization_.decrease();
  } else if (search_.step <= kShortStep && !equality_search_) {
    // (Equality rows must be met at any weight, so the weight does not shorten the step there.)
    regularize_more();
  }
  last_stationarity_ = row.stationarity;
  return true;
}

/// Increases the regularization; false at its limit, or at that of the sweeps. The smallest one is
/// an absolute weight and may be far above the curvature of the costs in the controls. That
/// curvature is 1e-8 for thrusts in kilonewtons; the weight would then stall a solve for hundreds
/// of iterations.
bool Globalization::regularize_more() {
  if (!direction_.qp().may_sweep()) return false;
  if (regularization_.value() == 0)
    regularization_.lower_min(kCurvatures * iterate_.hessian.by_gauss_newton([this] {
      return control_curvature_.least(iterate_.linearization, outer_.augmentation());
    }));
  return regularization_.increase();
}

/// Finds directions and searches along them, with more regularization after every failure, until a
/// step is found.
bool Globalization::find_step(bool& by_full_step) {
  bool goes_on = true;
  while (goes_on) {
    if (!prepare_direction()) return false;
    bool descends = true;
    if (try_step(by_full_step, descends)) return true;
    goes_on = at_rounding_floor_ ? leave_rounding_floor() : retry_regularized(descends);
  }
  return false;
}

/// Computes a direction and its merit.
bool Globalization::prepare_direction() {
  do {
    if (!sweep()) return false;
  } while (raise_for_unsettled());
  if (direction_.null_space() != nullptr)
    multiplier_change_ = &direction_.null_space()->find_multipliers(direction_.step());
  correct_direction();
  measure_direction();
  return true;
}

bool Globalization::try_step(bool& by_full_step, bool& descends) {
  by_full_step = take_full_step();
  return by_full_step || search(descends) || search_uncorrected(descends);
}

/// Turns to exact Hessians, which gain the last digits in one step where Gauss-Newton creeps. False
/// if they have been tried; the solve then ends.
bool Globalization::leave_rounding_floor() {
  if (!iterate_.hessian.turn()) return end_at_rounding_floor();
  at_rounding_floor_ = false;
  differentiate();
  return true;
}

/// Increases the regularization after a failure. False if the solve ends.
bool Globalization::retry_regularized(bool descends) {
  if (!regularize_more()) return end_without_step(descends);
  return record_.budget_left();
}

/// Searches along the sweep's own direction if it was corrected.
bool Globalization::search_uncorrected(bool& descends) {
  if (!direction_.corrected()) return false;
  at_rounding_floor_ = false;
  direction_.undo_correction(iterate_.linearization, iterate_.trajectory, iterate_.gaps);
  measure_direction();
  return search(descends);
}

/// Updates the searches after a successful step.
void Globalization::step_taken(bool by_full_step) {
  if (multiplier_change_ != nullptr) {
    outer_.add(*multiplier_change_, search_.step);
    iterate_.linearized = false;
  }
  const bool full = search_.step == 1;
  const bool quadratic = decrease_was_quadratic(by_full_step);
  if (full && direction_.qp().within_bounds() && quadratic)
    direction_.step_taken();
  else
    direction_.forget_steps();
  full_step_search_.step_taken(full && quadratic);
}

/// True if the decrease of the full step was that of a quadratic function.
bool Globalization::decrease_was_quadratic(bool by_full_step) {
  if (merit_.hidden(search_.expected_decrease)) return true;
  const double share = share_of_decrease(by_full_step);
  return share >= kQuadraticFrom && share <= kQuadraticTo;
}

/// The actual decrease as a share of the expected one. While a line search closes gaps, their
/// weight dominates the gain of the merit, so the cost alone is compared with its model.
double Globalization::share_of_decrease(bool by_full_step) {
  const bool closed_gaps =
      !by_full_step && !equality_search_ && !iterate_.gaps.closed() && search_.step == 1;
  if (!closed_gaps) return search_.actual_decrease / search_.expected_decrease;
  const double model = -merit_.slope - 0.5 * direction_.curvature(iterate_.linearization);
  return 0.5 * (search_.actual_decrease - merit_.penalty * merit_.gap_norm) / model;
}

/// Corrects Gauss-Newton steps by earlier ones, if the recipe allows other Hessians.
void Globalization::correct_direction() {
  const Stopwatch watch(record_.result.times.sweep);
  if (recipe_.hessian == HessianUse::when_slow && outer_.augmentation() == nullptr &&
      !iterate_.hessian.exact_in_use() && regularization_.value() == 0) {
    direction_.correct(iterate_.linearization, iterate_.trajectory, iterate_.gaps);
  } else {
    direction_.forget_steps();
  }
}

/// Computes the merit's view of the full step.
void Globalization::measure_direction() {
  const Stopwatch watch(record_.result.times.sweep);
  if (equality_search_) {
    equality_search_->measure(iterate_.linearization, iterate_.trajectory, *outer_.augmentation(),
                              *outer_.multipliers(), direction_.step(),
                              direction_.curvature(iterate_.linearization), merit_);
    return;
  }
  merit_.slope = direction_.step().slope();
  merit_.slope_within_bounds = direction_.qp().within_bounds();
  // Co-states without gains say little about the rounding of the cost.
  if (record_.row.iteration == 0 || !merit_.slope_within_bounds) {
    iterate_.adjoint.compute(iterate_.linearization, iterate_.trajectory, iterate_.gaps,
                             feedback());
    merit_.rounding = iterate_.adjoint.cost_rounding(iterate_.linearization, iterate_.trajectory);
  }
}

/// Sets the weight of the gaps in the merit.
void Globalization::weigh_gaps() {
  if (!recipe_.open_gaps || equality_search_) return;
  const Stopwatch watch(record_.result.times.sweep);
  if (!gaps_open()) {
    merit_.penalty = kMeritMargin * iterate_.adjoint.costates().lpNorm<Eigen::Infinity>();
  } else {
    merit_.penalty = open_gap_search_.weigh(merit_, direction_.curvature(iterate_.linearization));
  }
}

/// Raises the regularization, as far as this may help, if the active set of the direction has not
/// settled. A step far from the iterate makes the controls' active set alternate.
bool Globalization::raise_for_unsettled() {
  return direction_.qp().set_unknown() && !direction_.qp().trusts_model() &&
         regularization_.value() < kSettlingRegularization && regularize_more();
}

/// True if the full step should be tried. Affine dynamics leave no gaps to correct, and the line
/// search then takes fewer iterations.
bool Globalization::full_step_is_due() const {
  return recipe_.open_gaps && !equality_search_ && direction_.qp().within_bounds() &&
         !iterate_.hessian.exact_wanted() && !(regularization_.value() > 0) &&
         full_step_search_.due() && !direction_.qp().trusts_model();
}

/// Takes the full step of the linear model if full steps succeed.
bool Globalization::take_full_step() {
  if (!full_step_is_due()) return false;
  iterate_.before = iterate_.trajectory;
  // Multipliers are updated only when the gaps are closed.
  const FullStepSearch::Goal goal{.last = record_.row.stationarity * record_.row.stationarity <=
                                          options_.tolerances.stationarity * last_stationarity_,
                                  .close = outer_.augmentation() != nullptr};
  const LineSearchResult found =
      full_step_search_.run(iterate_, merit_, direction_, outer_.augmentation(), goal);
  record_.row.trials += found.trials;
  if (found.accepted && (!found.by_rounding || blind_step_progresses())) {
    search_ = found;
    // No search weighed the gaps, but the log reports the weight that they would have.
    merit_.penalty =
        kMeritMargin *
        iterate_.adjoint.costates().rightCols(problem_.knots()).lpNorm<Eigen::Infinity>();
    return true;
  }
  full_step_search_.reject();
  iterate_.trajectory = iterate_.before;
  if (found.accepted || !iterate_.linearized) differentiate();
  return false;
}

/// Searches along the sweep's policy if it descends.
bool Globalization::search(bool& descends) {
  weigh_gaps();
  descends = merit_.descends();
  if (!descends) return false;
  iterate_.before = iterate_.trajectory;
  if (gaps_open() && !merit_.hidden(merit_.merit_slope())) return search_with_open_gaps();
  return search_judged();
}

/// Searches for a step. If the merit is too coarse to judge it, the step must make progress
/// otherwise.
bool Globalization::search_judged() {
  for (double first_step = 1; first_step >= kShortestBlindStep; first_step /= 2) {
    if (!search_along(first_step)) return false;
    if (!search_.by_rounding || blind_step_progresses()) return true;
    iterate_.trajectory = iterate_.before;
    differentiate();
  }
  at_rounding_floor_ = true;
  return false;
}

bool Globalization::search_with_open_gaps() {
  const Stopwatch watch(record_.result.times.rollout);
  search_ = open_gap_search_.run(iterate_.evaluator, merit_, iterate_.linearization, direction_,
                                 outer_.augmentation(), iterate_.trajectory);
  record_.row.trials += search_.trials;
  iterate_.linearized = iterate_.linearized && !search_.accepted;
  return search_.accepted;
}

bool Globalization::search_along(double first_step) {
  const Stopwatch watch(record_.result.times.rollout);
  if (equality_search_)
    search_ = equality_search_->run(iterate_.evaluator, merit_, iterate_.linearization,
                                    direction_.step(), feedback(), first_step, iterate_.trajectory);
  else
    search_ = line_search_.run(iterate_.evaluator, merit_, iterate_.adjoint,
                               iterate_.linearization.gap, feedback(),
                               {.contract_gaps = recipe_.open_gaps,
                                .clamp_controls = recipe_.clamp_controls,
                                .augmentation = outer_.augmentation()},
                               first_step, iterate_.trajectory);
  record_.row.trials += search_.trials;
  if (search_.accepted) iterate_.linearized = false;
  return search_.accepted;
}

/// Differentiates the trajectory. True if the stationarity fell or, when it is already under
/// tolerance, the gaps did: a constant cost gives gaps zero weight.
bool Globalization::blind_step_progresses() {
  differentiate();
  if (!iterate_.linearized) return false;
  const IterationRecord& row = record_.row;
  const double stationarity = iterate_.stationarity().value;
  if (stationarity < kBlindProgress * row.stationarity) return true;
  return row.gap > options_.tolerances.gap && stationarity <= options_.tolerances.stationarity &&
         iterate_.linearization.max_gap() < kBlindProgress * row.gap;
}

/// Sweeps with as much regularization as necessary.
bool Globalization::sweep() {
  const Stopwatch watch(record_.result.times.sweep);
  for (;;) {
    const int bad_knot = sweep_backward(regularization_.value());
    if (bad_knot < 0) return true;
    if (find_non_finite(iterate_.linearization)) return iterate_.end_diverged();
    if (!regularize_more()) {
      record_.result.failed_knot = bad_knot;
      record_.result.failed_quantity = "Q_uu";
      return record_.end(SolveStatus::regularization_limit,
                         fmt::format("Q_uu at knot {} is not positive definite with the largest "
                                     "regularization {:.1e}: {}",
                                     bad_knot, regularization_.value(), record_.residual_text()));
    }
    if (!record_.budget_left()) return false;
  }
}

/// Returns the knot of a stage without a minimum, or −1. Exact Hessians may be indefinite far from
/// an optimum. Gauss-Newton Hessians, with the costs' curvature and the problem's own scaling, are
/// then a better convex model than any multiple of the identity. Costs without such curvature are
/// an exception.
int Globalization::sweep_backward(double regularization) {
  if (iterate_.hessian.exact_known()) {
    iterate_.hessian.use(true);
    const int bad_knot = find_settled_direction(regularization);
    if (bad_knot < 0 || iterate_.hessian.exact_alone()) return bad_knot;
  }
  iterate_.hessian.use(false);
  return find_settled_direction(regularization);
}

/// Repeats the search with a trusted model if active sets alternate and the problem is affine.
int Globalization::find_settled_direction(double regularization) {
  const int bad_knot = find_direction(regularization);
  if (!direction_.qp().unsettled() || !found_affine()) return bad_knot;
  direction_.qp().trust_model();
  return find_direction(regularization);
}

int Globalization::find_direction(double regularization) {
  return direction_.find(iterate_.linearization, iterate_.trajectory, iterate_.gaps,
                         iterate_.adjoint, regularization, outer_.augmentation());
}

/// Tests once whether dynamics and constraints are affine. True if this test finds them affine.
bool Globalization::found_affine() {
  if (!affine_probe_ || affine_known_) return false;
  affine_known_ = true;
  return affine_probe_->holds(iterate_.evaluator, iterate_.trajectory, iterate_.linearization);
}

double Globalization::newton_gain() {
  const Stopwatch watch(record_.result.times.sweep);
  if (sweep_backward(0) >= 0) return 0;
  return std::max(0.0, -0.5 * direction_.step().slope());
}

std::optional<double> Globalization::find_gains() {
  const Stopwatch watch(record_.result.times.sweep);
  direction_.qp().stay_at_iterate();
  RegularizationSchedule schedule;
  do {
    if (sweep_backward(schedule.value()) < 0) return schedule.value();
  } while (schedule.increase());
  return std::nullopt;
}

double Globalization::contradiction() {
  return equality_search_ ? direction_.null_space()->contradiction() : 0;
}

/// True if the decrease is hidden only because the regularization is large: without it, the model
/// predicts more than rounding. Leaves that direction's slope in the merit.
bool Globalization::regularisation_hides_descent() {
  if (regularization_.value() == 0 || sweep_backward(0) >= 0) return false;
  measure_direction();
  return !merit_.hidden(merit_.merit_slope());
}

bool Globalization::end_at_rounding_floor() {
  if (regularisation_hides_descent()) return end_without_step(merit_.descends());
  record_.result.failed_quantity = kRoundedCost;
  return record_.end(SolveStatus::line_search_failed,
                     fmt::format("the cost's rounding ({:.1e}) hides what is left to gain, and the "
                                 "stationarity does not fall any more: {}",
                                 merit_.rounding, record_.residual_text()));
}

bool Globalization::end_without_step(bool descends) {
  std::string cause;
  if (!descends) {
    cause = fmt::format("the direction does not descend (slope {:.1e})", merit_.merit_slope());
  } else {
    cause = fmt::format("no step length down to {:.1e} lowers the merit (slope {:.1e})", kLeastStep,
                        merit_.merit_slope());
    if (search_.first_bad_knot >= 0) {
      record_.result.failed_knot = search_.first_bad_knot;
      record_.result.failed_quantity = "motion";
      cause += fmt::format(", and longer ones are not finite at knot {}", search_.first_bad_knot);
    }
  }
  return record_.end(SolveStatus::line_search_failed,
                     fmt::format("{} with regularization up to {:.1e}: {}", cause,
                                 regularization_.value(), record_.residual_text()));
}

}  // namespace conddp
