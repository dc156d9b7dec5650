#include "solvers/stages/active_set.hpp"

#include <algorithm>

namespace conddp {
namespace {

bool is_free(BoundState state) { return state == BoundState::free; }

BoundState state_of_side(double side) {
  if (side < 0) return BoundState::at_lower;
  return side > 0 ? BoundState::at_upper : BoundState::free;
}

}  // namespace

ActiveSet::ActiveSet(const ShootingProblem& problem) {
  for (int k = 0; k < problem.knots(); ++k) {
    const int nu = problem.nu(k);
    knots_.push_back({std::vector<BoundState>(nu), Eigen::MatrixXd(problem.ndx(), nu),
                      Eigen::MatrixXd(nu, nu), Eigen::VectorXd(nu), Eigen::VectorXd(nu),
                      Eigen::VectorXd(nu)});
  }
}

void ActiveSet::begin_sweep(bool hold) {
  changes_ = 0;
  hold_ = hold;
}

/// State of a free entry of δu after a step.
BoundState ActiveSet::Knot::beyond(int i, double du) const {
  if (du > upper[i]) return BoundState::at_upper;
  return du < lower[i] ? BoundState::at_lower : BoundState::free;
}

/// State of a held entry after a step: free if its multiplier has the wrong sign.
BoundState ActiveSet::Knot::by_multiplier(int i, const Eigen::Ref<const Eigen::VectorXd>& dx,
                                          const Eigen::Ref<const Eigen::VectorXd>& du) const {
  if (!(lower[i] < upper[i])) return states[i];
  const double gradient = Qu[i] + Quu.col(i).dot(du) + Qxu.col(i).dot(dx);
  return (states[i] == BoundState::at_lower) == (gradient < 0) ? BoundState::free : states[i];
}

int ActiveSet::revise(int knot, const Eigen::Ref<const Eigen::VectorXd>& dx,
                      const Eigen::Ref<const Eigen::VectorXd>& du) {
  if (knots_.empty()) return 0;
  Knot& seen = knots_[knot];
  int changes = 0;
  for (int i = 0; i < du.size(); ++i) {
    const BoundState state =
        is_free(seen.states[i]) ? seen.beyond(i, du[i]) : seen.by_multiplier(i, dx, du);
    changes += state != seen.states[i];
    seen.states[i] = state;
  }
  changes_ += changes;
  return changes;
}

void ActiveSet::assume_sides(int knot, const Eigen::Ref<const Eigen::VectorXd>& side) {
  for (int i = 0; i < side.size(); ++i) {
    BoundState& state = knots_[knot].states[i];
    const BoundState now = state_of_side(side[i]);
    changes_ += state != now;
    state = now;
  }
}

void ActiveSet::assume_pushed_out(const ControlBounds& bounds, const Eigen::VectorXd& gradient,
                                  const Trajectory& trajectory) {
  for (int knot = 0; knot < static_cast<int>(knots_.size()); ++knot) {
    const auto u = trajectory.u(knot);
    for (int i = 0; i < u.size(); ++i) {
      const double slope = gradient[bounds.offset(knot) + i];
      const bool pushed = bounds.pushed_out(knot, i, u[i], slope);
      BoundState& state = knots_[knot].states[i];
      state = pushed ? state_of_side(-slope) : BoundState::free;
      if (!(bounds.lower(knot)[i] < bounds.upper(knot)[i])) state = BoundState::at_lower;
    }
  }
}

void ActiveSet::release() {
  for (Knot& knot : knots_) std::fill(knot.states.begin(), knot.states.end(), BoundState::free);
}

bool ActiveSet::holds(int knot, int i) const {
  return !knots_.empty() && !is_free(knots_[knot].states[i]);
}

bool ActiveSet::holds_any(int knot) const {
  return !knots_.empty() &&
         !std::all_of(knots_[knot].states.begin(), knots_[knot].states.end(), is_free);
}

int ActiveSet::clamped_controls() const {
  int count = 0;
  for (const Knot& knot : knots_)
    count += static_cast<int>(knot.states.size() -
                              std::count_if(knot.states.begin(), knot.states.end(), is_free));
  return count;
}

void ActiveSet::bound(const StageProblem& stage) {
  Knot& knot = knots_[stage.knot];
  knot.lower = stage.lower - stage.u;
  knot.upper = stage.upper - stage.u;
}

void ActiveSet::remember(const StageProblem& stage) {
  Knot& knot = knots_[stage.knot];
  knot.Qxu = stage.Qxu.topRows(knot.Qxu.rows());
  knot.Quu = stage.Quu;
  knot.Qu = stage.Qu;
}

}  // namespace conddp
