#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "ocp/stopwatch.hpp"
#include "solvers/ddp_solver.hpp"
#include "solvers/finite_check.hpp"

namespace conddp {
namespace {

/// Shortest step that is tried where stationarity has to judge it, and the share to which it has
/// to fall.
constexpr double kShortestBlindStep = 1.0 / 16;
constexpr double kBlindProgress = 0.999;
/// Shares of the expected decrease that a model step has to reach, that its gaps, weighted by their
/// multipliers, may reach, and up to which they are left as they are.
constexpr double kModelStepDecrease = 0.1;
constexpr double kModelStepGaps = 0.5;
constexpr double kNegligibleGaps = 0.05;
/// The same share from which on a rollout is the shorter way, and the share of the gaps that a
/// correction may leave.
constexpr double kHopelessGaps = 10;
constexpr double kSlowCorrection = 0.5;
constexpr int kGapCorrections = 3;
/// Shares of the expected decrease between which a full step is one of a quadratic function: ½ of
/// the decrease at first is what a perfect model would give.
constexpr double kQuadraticFrom = 0.3, kQuadraticTo = 0.8;
/// Regularisation up to which a direction is looked for whose active set settles.
constexpr double kSettlingRegularization = 0.01;

}  // namespace

/// A step that can be given up half-way.
bool DdpSolver::try_step() {
  step_start_ = trajectory_;
  stepping_ = true;
  const bool taken = take_step();
  stepping_ = false;
  return taken;
}

/// Sweeps and searches, with more regularisation after every failure, until a step is accepted.
bool DdpSolver::take_step() {
  row_.trials = 0;
  bool by_model = false;
  const int sweeps_before = direction_.sweeps();
  for (;;) {
    if (!sweep_with_regularization()) return false;
    if (raise_for_unsettled()) continue;
    if (direction_.null_space() != nullptr)
      multiplier_change_ = &direction_.null_space()->find_multipliers(direction_.step());
    correct_direction();
    const MeritModel former_merit = merit_;
    measure_direction();
    bool descent = true, found = model_step();
    by_model = found;
    if (!found) {
      weigh_gaps();
      descent = merit_.descends();
      found = descent && search();
    }
    if (direction_.descended() && !(found && (search_.by_rounding || search_.step == 1))) {
      // The cost's model does not hold that far: a direction that stays near the iterate does
      // better.
      direction_.decline_descent();
      merit_ = former_merit;
      at_rounding_floor_ = false;
      if (found) trajectory_ = before_;
      linearized_ = true;
      continue;
    }
    if (found) break;
    if (direction_.corrected()) {
      at_rounding_floor_ = false;
      direction_.undo_correction(linearization_, trajectory_, gaps_);
      measure_direction();
      weigh_gaps();
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
      if (regularisation_hides_descent()) return end_without_step(merit_.descends());
      result_.failed_quantity = kRoundedCost;
      return end(SolveStatus::line_search_failed,
                 fmt::format("the cost's rounding ({:.1e}) hides what is left to gain, and the "
                             "stationarity does not fall any more: {}",
                             merit_.rounding, residual_text()));
    }
    if (!regularization_.increase()) return end_without_step(descent);
    if (!budget_left()) return false;
  }
  if (multiplier_change_ != nullptr) {
    constraints_->add(*multiplier_change_, search_.step);
    linearized_ = false;
  }
  const bool quadratic = decrease_was_quadratic(by_model);
  if (search_.step == 1 && direction_.within_bounds() && quadratic) {
    direction_.step_taken();
  } else {
    direction_.forget_steps();
  }
  if (search_.step == 1) direction_.admit_descent();
  full_steps_ = search_.step == 1 && quadratic ? full_steps_ + 1 : 0;
  row_.sweeps = direction_.sweeps() - sweeps_before;
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
  } else if (search_.step <= options_.regularization.increase_step && !equality_search_) {
    // (Rows have to be met whatever the weight: it does not make the step shorter there.)
    regularization_.increase();
  }
  return true;
}

/// Whether the decrease of the full step was that of a quadratic function. As long as a line search
/// closes gaps, their weight is most of what the merit gains, and the cost alone is compared with
/// its model.
bool DdpSolver::decrease_was_quadratic(bool by_model) {
  if (merit_.hidden(search_.expected_decrease)) return true;
  double share = search_.actual_decrease / search_.expected_decrease;
  if (!by_model && !equality_search_ && !gaps_.closed() && search_.step == 1) {
    const double model = -merit_.slope - 0.5 * direction_.curvature(linearization_);
    share = 0.5 * (search_.actual_decrease - merit_.penalty * merit_.gap_norm) / model;
  }
  return share >= kQuadraticFrom && share <= kQuadraticTo;
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

/// The model's view of the full step.
void DdpSolver::measure_direction() {
  const Stopwatch watch(result_.times.sweep);
  if (equality_search_) {
    equality_search_->measure(linearization_, trajectory_, *augmentation_,
                              constraints_->multipliers(), direction_.step(),
                              direction_.curvature(linearization_), merit_);
    return;
  }
  merit_.slope = direction_.step().slope();
  merit_.slope_within_bounds = direction_.within_bounds();
  // Co-states without gains say little of the cost's rounding.
  if (row_.iteration == 0 || !merit_.slope_within_bounds) {
    adjoint_.compute(linearization_, trajectory_, gaps_, direction_.feedback());
    merit_.rounding = adjoint_.cost_rounding(linearization_, trajectory_);
  }
}

/// Sets the weight of the gaps in the merit.
void DdpSolver::weigh_gaps() {
  if (!recipe_.open_gaps || equality_search_) return;
  const Stopwatch watch(result_.times.sweep);
  if (!gaps_open()) {
    open_gap_search_.reset();
    merit_.penalty =
        options_.line_search.merit_margin * adjoint_.costates().lpNorm<Eigen::Infinity>();
  } else {
    merit_.penalty = open_gap_search_.weigh(merit_, direction_.curvature(linearization_));
  }
}

/// A step far from the iterate makes the controls' active set alternate. Raises the regularisation,
/// as far as that may help, where the direction's set has not settled though gaps are open.
bool DdpSolver::raise_for_unsettled() {
  return gaps_open() && direction_.set_unknown() &&
         regularization_.value() < kSettlingRegularization && regularization_.increase();
}

/// The full step of the linear model instead of a rollout, as long as full steps go well. What it
/// leaves of gaps is judged by what closing them will cost, to first order Σ λᵀ gap: the merit's
/// ν Σ‖gap‖₁ would reject good steps near the optimum (Maratos' effect).
bool DdpSolver::model_step() {
  if (!recipe_.open_gaps || equality_search_ || !direction_.within_bounds() ||
      hessian_.exact_wanted() || regularization_.value() > 0 || full_steps_ < full_steps_wanted_) {
    return false;
  }
  // Affine dynamics leave no gaps to correct, and the line search takes fewer iterations there.
  if (direction_.trusts_model()) return false;
  // The step that should be the last one closes the gaps.
  const bool last = row_.stationarity * row_.stationarity <=
                    options_.tolerances.stationarity * last_stationarity_;
  before_ = trajectory_;
  const double closed_cost = merit_.cost + adjoint_.gap_slope();
  const double expected = adjoint_.gap_slope() - merit_.slope;
  const bool hidden = merit_.hidden(expected);
  const auto costates = adjoint_.costates().rightCols(problem_.knots());
  // Multipliers change where gaps are closed alone.
  const bool close = last || hidden || constraints_;
  double weight = 0, gap = 0;
  bool small = false, ahead = false;
  // The last look at the step becomes that of the next iterate, if it can be told to be the last.
  const auto look = [&](bool at_last, bool correct) {
    const Stopwatch watch(at_last ? result_.times.differentiate : result_.times.rollout);
    const auto how = at_last ? ModelStep::Look::differentiate : ModelStep::Look::evaluate;
    if (at_last) hessian_.begin_iterate();
    if (correct) {
      model_step_.correct(acts_, direction_.feedback(), how, linearization_, trajectory_,
                          augmentation_);
    } else {
      model_step_.take(acts_, direction_.step(), how, linearization_, trajectory_, augmentation_);
    }
    ahead = at_last;
    linearized_ = linearized_ && !at_last;
    weight = costates.cwiseProduct(model_step_.gap()).lpNorm<1>();
    gap = model_step_.gap().lpNorm<Eigen::Infinity>();
    small = close ? gap <= options_.tolerances.gap : weight <= kNegligibleGaps * expected;
  };
  look(first_look_suffices_ && !close, false);
  first_look_suffices_ = small;
  const bool hopeless = !std::isfinite(gap) || (!hidden && weight > kHopelessGaps * expected);
  for (int corrections = 0; !small && !hopeless && corrections < kGapCorrections; ++corrections) {
    const double former_gap = gap;
    look(correction_leaves_ * (close ? gap : weight) <=
             (close ? options_.tolerances.gap : kNegligibleGaps * expected),
         true);
    correction_leaves_ = gap / former_gap;
    if (!(gap <= kSlowCorrection * former_gap)) break;
  }
  const double actual =
      closed_cost - model_step_.cost() - costates.cwiseProduct(model_step_.gap()).sum();
  ++row_.trials;
  bool accepted =
      hidden ? merit_.hidden(actual)
             : actual >= kModelStepDecrease * expected && weight <= kModelStepGaps * expected;
  if (last && !(gap <= options_.tolerances.gap)) accepted = false;
  linearized_ = linearized_ && !accepted;
  differentiated_ = accepted && ahead;
  if (accepted && hidden && !blind_step_progresses()) {
    accepted = linearized_ = false;
  }
  if (accepted) {
    search_ = {.accepted = true,
               .step = 1,
               .expected_decrease = expected,
               .actual_decrease = actual,
               .trials = 1};
    // Nothing weighed the gaps, but the log says what weight they would have.
    merit_.penalty = options_.line_search.merit_margin * costates.lpNorm<Eigen::Infinity>();
    return true;
  }
  if (!last) {
    full_steps_wanted_ *= 2;
    full_steps_ = 0;
  }
  trajectory_ = before_;
  if (!linearized_) differentiate();
  return false;
}

/// Whether the decrease is too small to be seen because the regularisation is large: without it the
/// model sees more than rounding. Leaves that direction's slope in the merit.
bool DdpSolver::regularisation_hides_descent() {
  if (regularization_.value() == 0 || sweep_backward(0) >= 0) return false;
  measure_direction();
  return !merit_.hidden(merit_.merit_slope());
}

double DdpSolver::projected_stationarity() const {
  return bounds_.projected_norm(adjoint_.gradient(), trajectory_).value;
}

/// Line search along the sweep's policy. A step that the merit is too coarse to judge counts only
/// if it progresses otherwise.
bool DdpSolver::search() {
  before_ = trajectory_;
  if (gaps_open() && !merit_.hidden(merit_.merit_slope())) {
    const Stopwatch watch(result_.times.rollout);
    search_ =
        open_gap_search_.run(acts_, merit_, linearization_, direction_, augmentation_, trajectory_);
    row_.trials += search_.trials;
    linearized_ = linearized_ && !search_.accepted;
    return search_.accepted;
  }
  for (double first_step = 1; first_step >= kShortestBlindStep; first_step /= 2) {
    {
      const Stopwatch watch(result_.times.rollout);
      search_ =
          equality_search_
              ? equality_search_->run(acts_, merit_, linearization_, direction_.step(),
                                      direction_.feedback(), first_step, trajectory_)
              : line_search_.run(acts_, merit_, adjoint_, linearization_.gap, direction_.feedback(),
                                 {.contract_gaps = recipe_.open_gaps,
                                  .clamp_controls = recipe_.clamp_controls,
                                  .augmentation = augmentation_},
                                 first_step, trajectory_);
    }
    row_.trials += search_.trials;
    if (!search_.accepted) return false;
    linearized_ = false;
    if (!search_.by_rounding || blind_step_progresses()) return true;
    trajectory_ = before_;
    differentiate();
  }
  at_rounding_floor_ = true;
  return false;
}

/// Whether stationarity fell, or gaps where there is none to fall: a cost that is constant weighs
/// them with nothing.
bool DdpSolver::blind_step_progresses() {
  differentiate();
  if (!linearized_) return false;
  if (projected_stationarity() < kBlindProgress * row_.stationarity) return true;
  return row_.gap > options_.tolerances.gap &&
         projected_stationarity() <= options_.tolerances.stationarity &&
         linearization_.max_gap() < kBlindProgress * row_.gap;
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
    const auto find = [&] {
      return direction_.find(linearization_, trajectory_, gaps_, adjoint_, merit_,
                             {options_.regularization.kind, regularization}, augmentation_);
    };
    int bad_knot = find();
    if (affine_probe_ && direction_.unsettled() && !affine_known_) {
      affine_known_ = true;
      if (affine_probe_->holds(acts_, trajectory_, linearization_)) {
        direction_.trust_model();
        bad_knot = find();
      }
    }
    if (bad_knot < 0 || !exact) return bad_knot;
  }
  return -1;
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
             fmt::format("{} with regularisation up to {:.1e}: {}", cause, regularization_.value(),
                         residual_text()));
}

}  // namespace conddp
