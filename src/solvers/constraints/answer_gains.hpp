#pragma once

#include <optional>

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/common/control_bounds.hpp"

namespace conddp {

/// Gains of a sweep at an answer.
struct AnswerGains {
  Feedback feedback;                     ///< zero if no sweep succeeds
  std::optional<double> regularization;  ///< of that sweep; empty if none succeeds
  Eigen::VectorXd penalty;               ///< of each constraint row in it
};

/// Sweeps at a trajectory, with constraints as penalties of the same size as the costs.
AnswerGains gains_at(const ShootingProblem& problem, const ControlBounds& bounds,
                     Evaluator& evaluator, const Trajectory& trajectory,
                     const Eigen::VectorXd& multipliers);

}  // namespace conddp
