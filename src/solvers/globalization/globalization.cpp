#include "solvers/globalization/globalization.hpp"

#include <string>

#include <fmt/format.h>

#include "base/stopwatch.hpp"
#include "solvers/common/finite_check.hpp"
#include "solvers/common/tuning.hpp"

namespace conddp {

Globalization::Globalization(const ShootingProblem& problem, const ControlBounds& bounds,
                             const DdpRecipe& recipe, const SolverOptions& options,
                             Iterate& iterate, OuterStrategy& outer, SolveRecord& record)
    : recipe_(recipe),
      options_(options),
      iterate_(iterate),
      outer_(outer),
      record_(record),
      direction_(problem, bounds,
                 {.clamp_controls = recipe.clamp_controls,
                  .box_stage = recipe.box_stage,
                  .null_space = recipe.multipliers == MultiplierSchedule::by_the_sweep &&
                                !problem.constraints().empty()}),
      rule_(problem, bounds, recipe, options, iterate, outer, record, direction_),
      control_curvature_(problem),
      regularization_(options.regularization.initial) {
  if (direction_.qp().has_rows()) affine_probe_.emplace(problem);
}

void Globalization::reset(int sweeps) {
  regularization_ = RegularizationSchedule(options_.regularization.initial);
  direction_.reset(sweeps);
  rule_.reset();
  affine_known_ = false;
}

void Globalization::begin_minimization() {
  regularization_ = RegularizationSchedule(options_.regularization.initial);
  rule_.begin_minimization();
}

/// Sweeps and searches, with more regularization after every failure, until a step is accepted.
bool Globalization::step() {
  IterationRecord& row = record_.row;
  row.trials = 0;
  const int sweeps_before = direction_.qp().sweeps();
  if (!find_step()) return false;
  if (multiplier_change_ != nullptr) {
    outer_.add(*multiplier_change_, rule_.found().step);
    iterate_.linearized = false;
  }
  rule_.step_taken();
  row.sweeps = direction_.qp().sweeps() - sweeps_before;
  row.step = rule_.found().step;
  row.expected_decrease = rule_.found().expected_decrease;
  row.actual_decrease = rule_.found().actual_decrease;
  row.regularization = regularization_.value();
  row.penalty = rule_.merit().penalty;
  row.exact_hessian = iterate_.hessian.exact_in_use();
  row.clamped_controls = direction_.qp().active_set().clamped_controls();
  row.active_set_changes = direction_.qp().active_set().changes();
  if (row.step >= tuning::kLongStep) {
    regularization_.decrease();
  } else if (row.step <= tuning::kShortStep && !rule_.keeps_equalities()) {
    // (Equality rows must be met at any weight, so the weight does not shorten the step there.)
    regularize_more();
  }
  return true;
}

/// Increases the regularization; false at its limit, or at that of the sweeps. The smallest one is
/// an absolute weight and may be far above the curvature of the costs in the controls. That
/// curvature is 1e-8 for thrusts in kilonewtons; the weight would then stall a solve for hundreds
/// of iterations.
bool Globalization::regularize_more() {
  if (!direction_.qp().may_sweep()) return false;
  if (regularization_.value() == 0)
    regularization_.lower_min(iterate_.hessian.by_gauss_newton([this] {
      return control_curvature_.least(iterate_.linearization, outer_.augmentation());
    }));
  return regularization_.increase();
}

/// Finds directions and searches along them, with more regularization after every failure, until a
/// step is found.
bool Globalization::find_step() {
  bool goes_on = true;
  while (goes_on) {
    if (!prepare_direction()) return false;
    if (rule_.take_step(regularization_.value() > 0)) return true;
    goes_on = rule_.at_rounding_floor() ? leave_rounding_floor() : retry_regularized();
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
  rule_.measure_direction();
  return true;
}

/// Turns to exact Hessians, which gain the last digits in one step where Gauss-Newton creeps. False
/// if they have been tried; the solve then ends.
bool Globalization::leave_rounding_floor() {
  if (!iterate_.hessian.turn()) return end_at_rounding_floor();
  rule_.leave_rounding_floor();
  iterate_.differentiate(feedback(), outer_.augmentation());
  return true;
}

/// Increases the regularization after a failure. False if the solve ends.
bool Globalization::retry_regularized() {
  if (!regularize_more()) return end_without_step();
  return record_.budget_left();
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

/// Raises the regularization, as far as this may help, if the active set of the direction has not
/// settled. A step far from the iterate makes the controls' active set alternate.
bool Globalization::raise_for_unsettled() {
  return direction_.qp().set_unknown() && !direction_.qp().trusts_model() &&
         regularization_.value() < tuning::kSettlingRegularization && regularize_more();
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
  return rule_.keeps_equalities() ? direction_.null_space()->contradiction() : 0;
}

/// True if the decrease is hidden only because the regularization is large: without it, the model
/// predicts more than rounding. Leaves that direction's slope in the merit.
bool Globalization::regularisation_hides_descent() {
  if (regularization_.value() == 0 || sweep_backward(0) >= 0) return false;
  rule_.measure_direction();
  return !rule_.merit().hidden(rule_.merit().merit_slope());
}

bool Globalization::end_at_rounding_floor() {
  if (regularisation_hides_descent()) return end_without_step();
  record_.result.failed_quantity = kRoundedCost;
  return record_.end(SolveStatus::line_search_failed,
                     fmt::format("the cost's rounding ({:.1e}) hides what is left to gain, and the "
                                 "stationarity does not fall any more: {}",
                                 rule_.merit().rounding, record_.residual_text()));
}

bool Globalization::end_without_step() {
  const double slope = rule_.merit().merit_slope();
  std::string cause;
  if (!rule_.merit().descends()) {
    cause = fmt::format("the direction does not descend (slope {:.1e})", slope);
  } else {
    cause = fmt::format("no step length down to {:.1e} lowers the merit (slope {:.1e})",
                        tuning::kLeastStep, slope);
    if (rule_.found().first_bad_knot >= 0) {
      record_.result.failed_knot = rule_.found().first_bad_knot;
      record_.result.failed_quantity = "motion";
      cause +=
          fmt::format(", and longer ones are not finite at knot {}", rule_.found().first_bad_knot);
    }
  }
  return record_.end(SolveStatus::line_search_failed,
                     fmt::format("{} with regularization up to {:.1e}: {}", cause,
                                 regularization_.value(), record_.residual_text()));
}

}  // namespace conddp
