#pragma once

#include <optional>

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/common/options.hpp"
#include "solvers/globalization/direction.hpp"
#include "solvers/globalization/line_search.hpp"

namespace conddp {

/// The search of a step as long as gaps are open, on the merit φ = J + ν Σ‖gap‖₁ with a weight ν
/// that is steered: it is just large enough for the step's model to pay for what the step costs
/// (Byrd, Nocedal, Waltz 2008; Nocedal, Wright, equation 18.36). So
/// it can grow no further than the model's cost does, whatever the multipliers of a policy whose
/// active set has not settled.
///
/// For each step length 1, ½, ¼, ... there are up to two trials, the better one of which counts:
/// - the rollout of the policy, which contracts all gaps by 1 − α (Mastalli et al. 2020). It is
///   the best one near an optimum, and takes curved dynamics as they are. Far from one it closes
///   gaps at any price;
/// - the step of the linear model, x ⊕ α δx and u + α δu, in all knots at once: multiple shooting
///   (Bock, Plitt 1984), in which no error of one knot travels through those behind it. It counts
///   where gaps are at most 1.5 times what they were: gaps that are opened for a lower cost have to
///   be closed at a far higher one.
class OpenGapSearch {
 public:
  OpenGapSearch(const ShootingProblem& problem, const ControlBounds& bounds,
                const SolverOptions::LineSearch& options, bool clamp_controls);

  /// ν for a step with that curvature dᵀHd, which is remembered.
  double weigh(const MeritModel& merit, double curvature);

  /// After weigh(), with that weight in `merit`. On acceptance `trajectory` becomes the new
  /// iterate, else it stays.
  LineSearchResult run(Evaluator& evaluator, const MeritModel& merit,
                       const Linearization& linearization, const Direction& direction,
                       const Augmentation* augmentation, Trajectory& trajectory);

 private:
  bool consider(double cost, double gap_norm, const MeritModel& merit, Trajectory& trial);
  void try_rollout(Evaluator& evaluator, const MeritModel& merit,
                   const Linearization& linearization, const Direction& direction,
                   const Augmentation* augmentation, double step, const Trajectory& from);
  void try_linear(Evaluator& evaluator, const MeritModel& merit, const Direction& direction,
                  const Augmentation* augmentation, double step, const Trajectory& from);

  const ControlBounds& bounds_;
  const StateManifold& manifold_;
  SolverOptions::LineSearch options_;
  bool clamp_controls_;
  double curvature_ = 0;      ///< of the step that was weighed last
  double best_decrease_ = 0;  ///< of the merit, by the trials of the present step length
  std::optional<double> best_rollout_cost_;  ///< none where the best of them was no rollout
  Trajectory best_, trial_;
  SingleRollout rollout_;
  Evaluation evaluation_;
  Eigen::VectorXd dx_;  ///< scratch
};

}  // namespace conddp
