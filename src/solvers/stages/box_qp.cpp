#include "solvers/stages/box_qp.hpp"

#include <algorithm>
#include <cmath>

#include "solvers/common/tuning.hpp"
#include "solvers/linalg/cholesky.hpp"

namespace conddp {
namespace {

using VectorIn = Eigen::Ref<const Eigen::VectorXd>;
using MatrixIn = Eigen::Ref<const Eigen::MatrixXd>;

/// Limit of the iterations. Each changes the active set, mostly for the last time, and stages have
/// far fewer controls.
constexpr int kMostIterations = 100;

BoundState state_of(double x, double lower, double upper, double gradient, BoundState hint) {
  const bool at_lower = x <= lower, at_upper = x >= upper;
  if (at_lower && (at_upper || gradient > 0 || hint == BoundState::at_lower))
    return BoundState::at_lower;
  if (at_upper && (gradient < 0 || hint == BoundState::at_upper)) return BoundState::at_upper;
  return BoundState::free;
}

}  // namespace

BoxQp::BoxQp(int max_size)
    : x_(max_size),
      gradient_(max_size),
      direction_(max_size),
      step_(max_size),
      trial_(max_size),
      H_step_(max_size),
      factor_(max_size, max_size),
      rhs_(1, max_size),
      free_(max_size) {}

void BoxQp::start(const VectorIn& lower, const VectorIn& upper,
                  std::span<const BoundState> active) {
  for (int i = 0; i < size_; ++i) {
    double value = 0;
    if (active[i] == BoundState::at_lower) value = lower[i];
    if (active[i] == BoundState::at_upper) value = upper[i];
    if (!std::isfinite(value)) value = 0;
    x_[i] = std::max(lower[i], std::min(value, upper[i]));
  }
}

/// An entry at a bound is clamped if the gradient pushes it outwards: at the lower bound, a
/// positive gradient is optimal. Before the first step, `active` itself can be trusted instead,
/// because the gradient means little while the free entries are far from their optimum. Returns
/// true if the set of free entries changed.
bool BoxQp::update_free_set(const VectorIn& lower, const VectorIn& upper, bool trust,
                            std::span<BoundState> active) {
  bool changed = false;
  int count = 0;
  for (int i = 0; i < size_; ++i) {
    const BoundState hint = trust ? active[i] : BoundState::free;
    active[i] = state_of(x_[i], lower[i], upper[i], gradient_[i], hint);
    if (active[i] != BoundState::free) continue;
    changed = changed || count >= free_count_ || free_[count] != i;
    free_[count++] = i;
  }
  changed = changed || count != free_count_;
  free_count_ = count;
  return changed;
}

bool BoxQp::factor_free_block(const MatrixIn& H) {
  for (int j = 0; j < free_count_; ++j) {
    for (int i = j; i < free_count_; ++i) factor_.col(j)[i] = H(free_[i], free_[j]);
  }
  return cholesky_in_place(free_factor());
}

bool BoxQp::free_gradient_vanishes(double rounding) const {
  for (int i = 0; i < free_count_; ++i) {
    if (!(std::abs(gradient_[free_[i]]) <= rounding)) return false;
  }
  return true;
}

/// Computes the Newton step of the free entries: −H_ff⁻¹ times the gradient.
void BoxQp::find_direction() {
  for (int i = 0; i < free_count_; ++i) rhs_.col(i)[0] = -gradient_[free_[i]];
  solve_rows_in_place(free_factor(), rhs_.block(1, 0, free_count_));
  direction_.head(size_).setZero();
  for (int i = 0; i < free_count_; ++i) direction_[free_[i]] = rhs_.col(i)[0];
}

BoxQp::Status BoxQp::solve(const MatrixIn& H, const VectorIn& g, const VectorIn& lower,
                           const VectorIn& upper, std::span<BoundState> active) {
  size_ = static_cast<int>(g.size());
  free_count_ = -1;  // no factor yet
  start(lower, upper, active);
  if (size_ == 0) return Status::solved;
  auto x = x_.head(size_);
  auto gradient = gradient_.head(size_);
  const double g_max = g.lpNorm<Eigen::Infinity>();
  const double H_max = H.cwiseAbs().maxCoeff();
  bool newton_point = false;  // x minimizes over its free entries
  for (iterations_ = 0; iterations_ < kMostIterations; ++iterations_) {
    gradient.noalias() = H * x;
    gradient += g;
    const bool first = iterations_ == 0;
    const bool changed = update_free_set(lower, upper, first, active);
    if (changed && !factor_free_block(H)) return Status::not_positive_definite;
    const double rounding = tuning::kUlps * (g_max + H_max * x.lpNorm<1>());
    if ((newton_point && !changed) || free_gradient_vanishes(rounding)) {
      if (!first) return Status::solved;
      continue;
    }
    find_direction();
    const Descent descent = search(H, lower, upper);
    if (descent == Descent::none) return Status::solved;
    newton_point = descent == Descent::newton;
    x = trial_.head(size_);  // not x + step, so that bounds are met exactly
  }
  return Status::iteration_limit;
}

/// Considers only entries that descend towards a bound. If the gradient points inwards, projection
/// only helps.
BoxQp::Block BoxQp::first_block(const VectorIn& lower, const VectorIn& upper) const {
  Block first;
  for (int n = 0; n < free_count_; ++n) {
    const int i = free_[n];
    if (!(gradient_[i] * direction_[i] < 0)) continue;
    const double bound = direction_[i] > 0 ? upper[i] : lower[i];
    const double length = (bound - x_[i]) / direction_[i];
    if (length < first.length) first = {i, length, bound};
  }
  return first;
}

/// Armijo's rule along the projection of the Newton direction. The change of the objective is
/// formed from the step itself, so that no cancellation hides it. If the free entries are strongly
/// coupled, projected steps ascend, and shorter ones end ever closer to the bound without meeting
/// it. Therefore the step to the first bound is tried, too.
BoxQp::Descent BoxQp::search(const MatrixIn& H, const VectorIn& lower, const VectorIn& upper) {
  auto step = step_.head(size_);
  auto H_step = H_step_.head(size_);
  const Block block = first_block(lower, upper);
  const double shortest = std::min(tuning::kRounding, block.length);
  for (double length = 1; length >= shortest && length > 0;) {
    const bool projected = project_trial(length, lower, upper);
    if (length == block.length) trial_[block.entry] = block.bound;
    step = trial_.head(size_) - x();
    H_step.noalias() = H * step;
    const double slope = gradient_.head(size_).dot(step);
    const double change = slope + 0.5 * step.dot(H_step);
    if (slope < 0 && change <= tuning::kArmijo * slope)
      return length == 1 && !projected ? Descent::newton : Descent::shorter;
    const bool passes = length > block.length && length / 2 < block.length;
    length = passes ? block.length : length / 2;
  }
  return Descent::none;
}

/// Forms the trial in the box. True if the box clamps an entry.
bool BoxQp::project_trial(double length, const VectorIn& lower, const VectorIn& upper) {
  bool projected = false;
  for (int i = 0; i < size_; ++i) {
    const double to = x_[i] + length * direction_[i];
    trial_[i] = std::max(lower[i], std::min(to, upper[i]));
    projected = projected || trial_[i] != to;
  }
  return projected;
}

}  // namespace conddp
