#include "solvers/iterate/stationarity_check.hpp"

#include <algorithm>
#include <cmath>

#include "solvers/common/tuning.hpp"

namespace conddp {
namespace {

/// Largest usable ratio of the gradient without gains to the stationarity.
constexpr double kMostAmplified = tuning::kGoalMargin / tuning::kLeastGoal;

double distance(const Eigen::MatrixXd& costates, const Eigen::MatrixXd& others) {
  return (costates - others).lpNorm<Eigen::Infinity>() /
         std::max(1.0, others.lpNorm<Eigen::Infinity>());
}

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
  agreed_ = false;
  if (goal_ <= tuning::kLeastGoal * options_.tolerances.stationarity) return true;
  const Apart apart = compare(iterate, multipliers);
  const double excess = std::max(apart.stationarity, apart.costates);
  agreed_ = !(excess > 1);
  return agreed_ || ask_for_less(iterate, excess);
}

bool StationarityCheck::confirm_gain(const Iterate& iterate, double share) {
  if (!(share > tuning::kMostGain)) return true;
  if (goal_ <= tuning::kLeastGoal * options_.tolerances.stationarity)
    return !(share > tuning::kMostGainAtEnd);
  return ask_for_less(iterate, std::sqrt(share / tuning::kMostGain));
}

/// Lowers the goal by this factor below the current stationarity. Returns false.
bool StationarityCheck::ask_for_less(const Iterate& iterate, double excess) {
  goal_ = std::max(tuning::kGoalMargin * iterate.stationarity().value / excess,
                   tuning::kLeastGoal * options_.tolerances.stationarity);
  return false;
}

const Adjoint* StationarityCheck::better(const Iterate& iterate,
                                         const Eigen::VectorXd* multipliers) {
  if (agreed_) return nullptr;
  const Apart apart = compare(iterate, multipliers);
  return apart.costates > 1 && apart.stationarity <= 1 ? &other() : nullptr;
}

const Adjoint& StationarityCheck::other() const { return plain_ ? plain_->adjoint() : *free_; }

StationarityCheck::Apart StationarityCheck::compare(const Iterate& iterate,
                                                    const Eigen::VectorXd* multipliers) {
  const double tolerance = options_.tolerances.stationarity;
  const std::optional<double> found =
      plain_
          ? plain_->stationarity(iterate.evaluator, iterate.trajectory, iterate.gaps, *multipliers)
          : reduced_stationarity(iterate, iterate.stationarity().value);
  if (!found) return {};
  double most = tolerance;
  if (plain_ && plain_->cost_gradient() > 0)
    most = std::min(most, tuning::kShareOfCost * plain_->cost_gradient());
  return {*found / most, distance(iterate.adjoint.costates(), other().costates()) /
                             (tuning::kCostateTolerance * tolerance)};
}

/// ‖∇_u L‖∞ without gains: the gradient of the cost as a function of only the controls. Empty if
/// open-loop dynamics amplify the residual too much: the gradient is then ill-conditioned.
std::optional<double> StationarityCheck::reduced_stationarity(const Iterate& iterate,
                                                              double stationarity) {
  free_->compute(iterate.linearization, iterate.trajectory, iterate.gaps, *no_feedback_);
  const double found = iterate.bounds.projected_norm(free_->gradient(), iterate.trajectory).value;
  if (!(found <= kMostAmplified * stationarity)) return std::nullopt;
  return found;
}

}  // namespace conddp
