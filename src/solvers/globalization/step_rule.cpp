#include "solvers/globalization/step_rule.hpp"

#include "base/stopwatch.hpp"
#include "solvers/common/tuning.hpp"

namespace conddp {

StepRule::StepRule(const ShootingProblem& problem, const ControlBounds& bounds,
                   const DdpRecipe& recipe, const SolverOptions& options, Iterate& iterate,
                   OuterStrategy& outer, SolveRecord& record, Direction& direction)
    : recipe_(recipe),
      options_(options),
      iterate_(iterate),
      outer_(outer),
      record_(record),
      direction_(direction),
      rows_(outer.augmentation() != nullptr && direction.null_space() != nullptr),
      line_search_(problem),
      open_gap_search_(problem, bounds, recipe.clamp_controls, rows_),
      full_step_search_(problem, bounds, options.tolerances) {}

void StepRule::reset() {
  line_search_.reset();
  full_step_search_.reset();
  found_ = LineSearchResult();
  merit_ = MeritModel();
  at_rounding_floor_ = false;
  last_stationarity_ = 0;
}

void StepRule::measure() {
  const Linearization& linearization = iterate_.linearization;
  merit_.cost = linearization.total_cost() + (rows_ ? 0 : linearization.augmentation.sum());
  merit_.gap_norm = rows_ ? open_gap_search_.gap_norm(linearization.gap, linearization.constraint)
                          : iterate_.gaps.norm();
  merit_.rounding = iterate_.adjoint.cost_rounding(linearization, iterate_.trajectory);
  record_.row.merit = merit_.value();
}

void StepRule::begin_minimization() {
  at_rounding_floor_ = false;
  merit_.cost = iterate_.linearization.total_cost() + iterate_.linearization.augmentation.sum();
}

void StepRule::measure_direction() {
  const Stopwatch watch(record_.result.times.sweep);
  merit_.slope = direction_.step().slope();
  merit_.slope_within_bounds = direction_.qp().within_bounds();
  // Co-states without gains say little about the rounding of the cost.
  if (record_.row.iteration == 0 || !merit_.slope_within_bounds) {
    iterate_.adjoint.compute(iterate_.linearization, iterate_.trajectory, iterate_.gaps,
                             direction_.feedback());
    merit_.rounding = iterate_.adjoint.cost_rounding(iterate_.linearization, iterate_.trajectory);
  }
}

bool StepRule::gaps_open() const {
  return rows_ || (recipe_.open_gaps && iterate_.gaps.norm() > options_.tolerances.gap);
}

/// Sets the weight of the gaps in the merit.
void StepRule::weigh_gaps() {
  if (!recipe_.open_gaps) return;
  const Stopwatch watch(record_.result.times.sweep);
  if (!gaps_open()) {
    // The penalty is exact from the largest multiplier on (Nocedal, Wright 2006, theorem 17.3).
    merit_.penalty = iterate_.adjoint.costates().lpNorm<Eigen::Infinity>();
    return;
  }
  double curvature = direction_.curvature(iterate_.linearization);
  if (rows_)
    open_gap_search_.leave_out(*outer_.augmentation(), *outer_.multipliers(),
                               iterate_.linearization.constraint, merit_.slope, curvature);
  merit_.penalty = open_gap_search_.weigh(merit_, curvature);
}

bool StepRule::take_step(bool regularized) {
  by_full_step_ = take_full_step(regularized);
  return by_full_step_ || search() || search_uncorrected();
}

/// Searches along the sweep's own direction if it was corrected.
bool StepRule::search_uncorrected() {
  if (!direction_.corrected()) return false;
  at_rounding_floor_ = false;
  direction_.undo_correction(iterate_.linearization, iterate_.trajectory, iterate_.gaps);
  measure_direction();
  return search();
}

void StepRule::step_taken() {
  const bool full = found_.step == 1;
  const bool quadratic = decrease_was_quadratic();
  if (full && direction_.qp().within_bounds() && quadratic)
    direction_.step_taken();
  else
    direction_.forget_steps();
  full_step_search_.step_taken(full && quadratic);
  last_stationarity_ = record_.row.stationarity;
}

/// True if the decrease of the full step was that of a quadratic function.
bool StepRule::decrease_was_quadratic() const {
  if (merit_.hidden(found_.expected_decrease)) return true;
  const double share = share_of_decrease();
  return share >= tuning::kQuadraticFrom && share <= tuning::kQuadraticTo;
}

/// The actual decrease as a share of the expected one. While a line search closes gaps, their
/// weight dominates the gain of the merit, so the cost alone is compared with its model.
double StepRule::share_of_decrease() const {
  const bool closed_gaps = !by_full_step_ && !rows_ && !iterate_.gaps.closed() && found_.step == 1;
  if (!closed_gaps) return found_.actual_decrease / found_.expected_decrease;
  const double model = -merit_.slope - 0.5 * direction_.curvature(iterate_.linearization);
  return 0.5 * (found_.actual_decrease - merit_.penalty * merit_.gap_norm) / model;
}

/// True if the full step should be tried. Affine dynamics leave no gaps to correct, and the line
/// search then takes fewer iterations.
bool StepRule::full_step_is_due(bool regularized) const {
  return recipe_.open_gaps && !rows_ && direction_.qp().within_bounds() &&
         !iterate_.hessian.exact_wanted() && !regularized && full_step_search_.due() &&
         !direction_.qp().trusts_model();
}

/// Takes the full step of the linear model if full steps succeed.
bool StepRule::take_full_step(bool regularized) {
  if (!full_step_is_due(regularized)) return false;
  iterate_.before = iterate_.trajectory;
  // Multipliers are updated only when the gaps are closed.
  const FullStepSearch::Goal goal{.last = record_.row.stationarity * record_.row.stationarity <=
                                          options_.tolerances.stationarity * last_stationarity_,
                                  .close = outer_.augmentation() != nullptr};
  const LineSearchResult found =
      full_step_search_.run(iterate_, merit_, direction_, outer_.augmentation(), goal);
  record_.row.trials += found.trials;
  if (found.accepted && (!found.by_rounding || blind_step_progresses())) {
    found_ = found;
    // No search weighed the gaps, but the log reports the weight that they would have.
    merit_.penalty = iterate_.adjoint.costates()
                         .rightCols(iterate_.trajectory.knots())
                         .lpNorm<Eigen::Infinity>();
    return true;
  }
  full_step_search_.reject();
  iterate_.trajectory = iterate_.before;
  if (found.accepted || !iterate_.linearized) differentiate();
  return false;
}

/// Searches along the sweep's policy if it descends. If the merit is too coarse to judge a step, it
/// must make progress otherwise.
bool StepRule::search() {
  weigh_gaps();
  if (!merit_.descends()) return false;
  iterate_.before = iterate_.trajectory;
  for (double first_step = 1; first_step >= tuning::kShortestHalf; first_step /= 2) {
    if (!search_along(first_step)) return false;
    if (!found_.by_rounding || blind_step_progresses()) return true;
    iterate_.trajectory = iterate_.before;
    differentiate();
  }
  at_rounding_floor_ = true;
  return false;
}

bool StepRule::search_along(double first_step) {
  const Stopwatch watch(record_.result.times.rollout);
  if (rows_ || (gaps_open() && !merit_.hidden(merit_.merit_slope())))
    found_ = open_gap_search_.run(iterate_.evaluator, merit_, iterate_.linearization, direction_,
                                  rows_ ? nullptr : outer_.augmentation(), first_step,
                                  iterate_.trajectory);
  else
    found_ = line_search_.run(iterate_.evaluator, merit_, iterate_.adjoint,
                              iterate_.linearization.gap, direction_.feedback(),
                              {.contract_gaps = recipe_.open_gaps,
                               .clamp_controls = recipe_.clamp_controls,
                               .augmentation = outer_.augmentation()},
                              first_step, iterate_.trajectory);
  record_.row.trials += found_.trials;
  if (found_.accepted) iterate_.linearized = false;
  return found_.accepted;
}

/// Differentiates the trajectory. True if the stationarity fell or, when it is already under
/// tolerance, the gaps did: a constant cost gives gaps zero weight.
bool StepRule::blind_step_progresses() {
  differentiate();
  if (!iterate_.linearized) return false;
  const IterationRecord& row = record_.row;
  const double stationarity = iterate_.stationarity().value;
  if (stationarity < tuning::kBlindProgress * row.stationarity) return true;
  return row.gap > options_.tolerances.gap && stationarity <= options_.tolerances.stationarity &&
         iterate_.linearization.max_gap() < tuning::kBlindProgress * row.gap;
}

}  // namespace conddp
