#include "analysis/certificate/motion_ranges.hpp"

#include <algorithm>

#include "analysis/certificate/replay.hpp"

namespace conddp {
namespace {

using Eigen::VectorXd;

/// Ranges below this share of the largest one are rounding and define no scale.
constexpr double kNoRange = 1e-12;

void drop_rounding(VectorXd& ranges) {
  if (ranges.size() == 0) return;
  const double least = kNoRange * ranges.maxCoeff();
  ranges = (ranges.array() > least).select(ranges, 0);
}

}  // namespace

MotionRanges::MotionRanges(const ShootingProblem& problem, const Trajectory& trajectory)
    : state_(motion_range(problem, trajectory)) {
  for (int k = 0; k < problem.knots(); ++k) {
    VectorXd& range = controls_[problem.knot(k).model];
    if (range.size() == 0) range = VectorXd::Zero(problem.nu(k));
    range = range.cwiseMax(trajectory.u(k).cwiseAbs());
  }
  drop_rounding(state_);
  for (auto& [model, range] : controls_) drop_rounding(range);
}

VectorXd MotionRanges::of_node(const ShootingProblem& problem, int k) const {
  if (k == problem.knots()) return state_;
  VectorXd all(state_.size() + problem.nu(k));
  all << state_, controls_.at(problem.knot(k).model);
  return all;
}

VectorXd MotionRanges::unit(const ShootingProblem& problem, int k) const {
  return of_node(problem, k).unaryExpr([](double r) { return r > 0 ? r : 1.0; });
}

VectorXd MotionRanges::reach(const ShootingProblem& problem, int k) const {
  const VectorXd ranges = of_node(problem, k);
  VectorXd reach = VectorXd::Ones(ranges.size());
  if (k == problem.knots() || problem.nu(k) == 0) return reach;
  const auto controls = ranges.tail(problem.nu(k));
  for (Eigen::Index i = 0; i < controls.size(); ++i)
    if (controls[i] == 0) reach[state_.size() + i] = std::max(1.0, controls.maxCoeff());
  return reach;
}

}  // namespace conddp
