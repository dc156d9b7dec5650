#include "solvers/iterate/stationarity_check.hpp"

#include <algorithm>

namespace conddp {
namespace {

/// The share of what should be enough that is asked for, and of the tolerance at least.
constexpr double kGoalMargin = 0.5, kLeastGoal = 1e-5;
/// How much larger a gradient without gains may be and still counts.
constexpr double kMostAmplified = kGoalMargin / kLeastGoal;

}  // namespace

StationarityCheck::StationarityCheck(const ShootingProblem& problem, const ControlBounds& bounds,
                                     const SolverOptions& options, bool constrained)
    : options_(options), goal_(options.tolerances.stationarity) {
  if (constrained) {
    plain_.emplace(problem, bounds);
    return;
  }
  free_.emplace(problem, bounds);
  no_feedback_.emplace(problem);
}

bool StationarityCheck::confirm(const Iterate& iterate, const Eigen::VectorXd* multipliers) {
  const double tolerance = options_.tolerances.stationarity;
  if (goal_ <= kLeastGoal * tolerance) return true;
  const double stationarity = iterate.stationarity().value;
  const std::optional<double> found =
      plain_ ? plain_->stationarity(iterate.evaluator, iterate.trajectory, iterate.gaps,
                                    options_.regularization, *multipliers)
             : reduced_stationarity(iterate, stationarity);
  if (!found || !(*found > tolerance)) return true;
  goal_ = std::max(kGoalMargin * stationarity * tolerance / *found, kLeastGoal * tolerance);
  return false;
}

/// ‖∇_u L‖∞ without gains, the gradient of the cost as a function of the controls alone. None where
/// open-loop dynamics amplify the residual too much: there it is ill-conditioned.
std::optional<double> StationarityCheck::reduced_stationarity(const Iterate& iterate,
                                                              double stationarity) {
  free_->compute(iterate.linearization, iterate.trajectory, iterate.gaps, *no_feedback_);
  const double found = iterate.bounds.projected_norm(free_->gradient(), iterate.trajectory).value;
  if (!(found <= kMostAmplified * stationarity)) return std::nullopt;
  return found;
}

}  // namespace conddp
