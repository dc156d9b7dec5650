#include "solvers/constraints/horizon_qp.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "solvers/common/tuning.hpp"
#include "solvers/linalg/exchange.hpp"

namespace conddp {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Evaluations of a line search, which bound a loop that rounding might not end.
constexpr int kEvaluations = 50;

struct SlopeAt {
  double step, slope;
};

/// Finds the step where an increasing slope, negative at `low` and positive at `high`, is at most
/// `allowed`. Uses regula falsi, which halves the value of an end that stays (Illinois).
template <class Slope>
double vanishing_slope(const Slope& slope_at, SlopeAt low, SlopeAt high, double allowed) {
  const SlopeAt* last_moved = nullptr;
  double step = high.step;
  for (int i = 0; i < kEvaluations; ++i) {
    step = (low.step * high.slope - high.step * low.slope) / (high.slope - low.slope);
    const double slope = slope_at(step);
    if (std::abs(slope) <= allowed) break;
    SlopeAt& moved = slope < 0 ? low : high;
    SlopeAt& stays = slope < 0 ? high : low;
    if (last_moved == &moved) stays.slope /= 2;
    moved = {step, slope};
    last_moved = &moved;
  }
  return step;
}

}  // namespace

HorizonQp::HorizonQp(const ShootingProblem& problem, const ControlBounds& bounds,
                     std::unique_ptr<StageSolver> stages, bool bounded, bool clamp)
    : problem_(problem),
      bounds_(bounds),
      bounded_(bounded),
      clamp_(clamp),
      sweep_(problem, bounds),
      stages_(std::move(stages)),
      rollout_(problem, bounds),
      rows_(problem, bounds),
      feedback_(problem),
      point_(rollout_.z()) {
  Eigen::Index largest = 0;
  for (const Eigen::VectorXd& z : point_) largest = std::max(largest, z.size());
  d_.resize(largest);
  product_.resize(largest);
}

void HorizonQp::reset(int most) {
  models_costs_ = true;
  sweeps_ = 0;
  most_sweeps_ = most;
  rows_.reset();
  set_start_ = SetStart::from_guess;
  model_true_ = false;
  feedback_.set_zero();
}

void HorizonQp::exchange_memory(HorizonQp& other) {
  sweep_.exchange_memory(other.sweep_);
  exchange(feedback_.K, other.feedback_.K);
  rows_.exchange_memory(other.rows_);
}

int HorizonQp::minimize(const Model& model, const Augmentation* augmentation) {
  models_rows_ =
      has_rows() && (augmentation != nullptr || (models_costs_ && problem_.constraints().empty()));
  unsettled_ = held_before_ = false;
  last_change_.reset();
  within_bounds_ = !bounded_ && !clamp_;
  if (models_rows_) {
    rows_.start(model.linearization, augmentation);
    rows_.expect(model.linearization);
  }
  const int bad_knot = bounded_ ? search_along_horizon(model) : search_by_stages(model);
  if (models_rows_ && rows_.restore(model.linearization)) {
    if (within_bounds_)
      rollout_.measure_slope(model.linearization);  // slope of the step that settled the search
    else
      roll(model, clamp_);
  }
  return bad_knot;
}

/// Sweeps until the linear rollout confirms the active set that the sweep assumed, starting from
/// the final set of the previous iteration. If sets alternate instead of settling, a descent
/// minimizes a true model. Otherwise stages find their own sets, around the rows of the iterate.
int HorizonQp::search_along_horizon(const Model& model) {
  const int bad_knot = sweep_first(model);
  if (bad_knot >= 0) return bad_knot;
  if (settle(model)) return -1;
  unsettled_ = models_rows_;
  if (minimize_true_model(model)) return -1;
  set_start_ = SetStart::by_stages;
  if (models_rows_) rows_.restore(model.linearization);
  return search_by_stages(model);
}

/// Sweeps with the initial active set of the search, or else with the sets that stages find. Far
/// from an optimum, stages hold many controls, each for a step that the next state will not take.
int HorizonQp::sweep_first(const Model& model) {
  if (set_start_ == SetStart::from_guess)
    stages_->active_set().assume_pushed_out(bounds_, model.gradient, model.trajectory);
  const bool swept = set_start_ != SetStart::by_stages && sweep(model, true) < 0;
  const int bad_knot = swept ? -1 : sweep(model, false);
  if (bad_knot < 0) set_start_ = SetStart::as_before;
  return bad_knot;
}

/// Minimizes a true model by a descent, after which the active set may settle. False if the model
/// contains no rows, is not known to be true, or a stage lacks a minimum.
bool HorizonQp::minimize_true_model(const Model& model) {
  if (!models_rows_ || !model_true_ || !descend(model)) return false;
  last_change_.reset();
  if (sweep(model, true) >= 0 || !settle(model)) write_point();
  return true;
}

int HorizonQp::search_by_stages(const Model& model) {
  const int bad_knot = sweep(model, false);
  if (bad_knot < 0) roll(model, clamp_);
  return bad_knot;
}

/// Consecutive held sweeps cover only the knots up to the last change.
int HorizonQp::sweep(const Model& model, bool hold) {
  const std::optional<int> from = hold && held_before_ ? last_change_ : std::nullopt;
  held_before_ = hold;
  ++sweeps_;
  return sweep_.run(model.linearization, model.trajectory, model.gaps, model.regularization,
                    *stages_, feedback_, hold, from);
}

/// Alternately revises the active set and sweeps until nothing changes. False if this does not end.
bool HorizonQp::settle(const Model& model) {
  int fewest = std::numeric_limits<int>::max(), since = 0;
  for (int i = 0; i < tuning::kSweeps; ++i) {
    const int changes = revise(model);
    within_bounds_ = changes == 0;
    if (within_bounds_) {
      if (models_rows_) rows_.settle();
      return true;
    }
    since = changes < fewest ? 0 : since + 1;
    fewest = std::min(fewest, changes);
    if (since > tuning::kRevisions) return false;
    if (!may_sweep() || sweep(model, true) >= 0) return false;
  }
  return false;
}

/// Number of the last sweep's assumptions that fail along the horizon.
int HorizonQp::revise(const Model& model) {
  roll(model, false);
  std::optional<int> last_row;
  int rows = 0;
  if (models_rows_) {
    // The model of an affine problem has the same minimum as the problem; other models only give a
    // step.
    const double allowed =
        model_true_ ? 0 : tuning::kModelError * rollout_.curvature(model.linearization);
    rows = rows_.revise(rollout_.z(), allowed, model.linearization, last_row);
  }
  last_change_.reset();
  const int changes = rollout_.revise(stages_->active_set(), last_change_);
  last_change_ = std::max(last_change_, last_row);
  if (last_row == problem_.knots()) last_change_.reset();  // every sweep begins there
  return changes + rows;
}

/// Descends from the response of the policy to the gaps, with control bounds as rows and an exact
/// line search along the step of each sweep. The function is convex and piecewise quadratic: the
/// descent converges even if active sets alternate under full steps. False if a stage lacks a
/// minimum.
bool HorizonQp::descend(const Model& model) {
  rows_.restore(model.linearization);
  rows_.restart();
  rollout_.respond(model.linearization, model.gaps, feedback_);
  for (std::size_t k = 0; k < point_.size(); ++k) point_[k] = rollout_.z()[k];
  rows_.begin_descent(model.trajectory, model.gradient, sweep_, model.linearization);
  std::optional<int> last;
  rows_.revise(point_, 0, model.linearization, last);
  stages_->active_set().release();
  bool swept = true;
  for (int i = 0; i < tuning::kSweeps; ++i) {
    held_before_ = false;
    swept = sweep(model, true) < 0;
    if (!swept) break;
    roll(model, false);
    if (advance(model)) break;
  }
  rows_.end_descent(stages_->active_set(), model.linearization);
  return swept;
}

/// Moves the point towards the minimum of the model around it, and the model with it. True if this
/// was the minimum.
bool HorizonQp::advance(const Model& model) {
  const double step = step_length(model);
  for (std::size_t k = 0; k < point_.size(); ++k) point_[k] += step * (rollout_.z()[k] - point_[k]);
  std::optional<int> last;
  const int changes = rows_.revise(point_, 0, model.linearization, last);
  return step == 0 || (step == 1 && changes == 0);
}

/// Finds the step where the derivative towards the minimum of the model vanishes; the derivative
/// increases with the step.
double HorizonQp::step_length(const Model& model) {
  double slope = 0, curvature = 0;
  for (std::size_t k = 0; k < point_.size(); ++k) {
    const KnotLinearization& knot = model.linearization.knots[k];
    auto d = d_.head(point_[k].size());
    auto product = product_.head(point_[k].size());
    d = rollout_.z()[k] - point_[k];
    product.noalias() = knot.hessian() * d;
    slope += knot.gradient.dot(d) + point_[k].dot(product);
    curvature += d.dot(product);
  }
  rows_.set_path(point_, rollout_.z(), model.linearization);
  const auto derivative = [&](double step) {
    return slope + step * curvature + rows_.slope_beyond_model(step);
  };
  const double at_start = derivative(0), at_end = derivative(1);
  if (!(at_start < 0)) return 0;
  if (at_end <= tuning::kExact * -at_start) return 1;
  return vanishing_slope(derivative, {0, at_start}, {1, at_end}, tuning::kSlopeLeft * -at_start);
}

/// Writes the point as δu = k + K δx with the present K.
void HorizonQp::write_point() {
  const int ndx = problem_.ndx();
  for (int k = 0; k < bounds_.knots(); ++k) {
    feedback_.k[k] = point_[k].tail(point_[k].size() - ndx);
    feedback_.k[k].noalias() -= feedback_.K[k] * point_[k].head(ndx);
  }
}

bool HorizonQp::satisfy(const Model& model, double penalty, Eigen::VectorXd& multipliers) {
  ActiveSet& active_set = stages_->active_set();
  active_set.assume_pushed_out(bounds_, model.gradient, model.trajectory);
  const double before = rows_.impose(multipliers, penalty, model.linearization);
  double last = kInfinity;
  for (int revisions = 0, corrections = 0; corrections < tuning::kTries;) {
    held_before_ = false;
    if (sweep(model, true) >= 0) return false;
    roll(model, false);
    std::optional<int> last_knot;
    const int changes = rows_.revise_active(rollout_.z(), model.linearization) +
                        rollout_.revise(active_set, last_knot);
    within_bounds_ = changes == 0;
    if (!within_bounds_ && ++revisions <= tuning::kTries) {
      last = kInfinity;
      continue;
    }
    const double rest = rows_.correct(rollout_.z(), model.linearization);
    if (rest <= tuning::kExact * before || rest >= tuning::kProgress * last) break;
    ++corrections;
    last = rest;
  }
  rows_.write_multipliers(multipliers);
  return rollout_.z().back().allFinite();
}

}  // namespace conddp
