#pragma once

#include <optional>

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/globalization/direction.hpp"
#include "solvers/globalization/line_search.hpp"

namespace conddp {

/// Search of a step while gaps are open, on the merit φ = J + ν Σ‖gap‖₁. The weight ν is just large
/// enough that the closed gaps pay for the cost of the model's step (Byrd, Nocedal, Waltz 2008;
/// Nocedal, Wright, equation 18.36). It therefore grows no further than the model's cost, whatever
/// the multipliers of a policy with an unsettled active set.
///
/// For each step length 1, ½, ¼, ... the better of up to two trials counts:
/// - The rollout of the policy contracts all gaps by 1 − α (Mastalli et al. 2020). It is the better
///   trial near an optimum, and follows curved dynamics as they are. Far from an optimum, it closes
///   gaps at any price.
/// - The step of the linear model, x ⊕ α δx and u + α δu, at all knots at once is multiple shooting
///   (Bock, Plitt 1984). The error of a knot does not propagate to later knots. The step counts if
///   gaps grow to at most 1.5 times their previous size: gaps opened for a lower cost have to be
///   closed at a far higher one.
class OpenGapSearch {
 public:
  OpenGapSearch(const ShootingProblem& problem, const ControlBounds& bounds, bool clamp_controls);

  /// Weight ν for a step with curvature dᵀHd, which is stored.
  double weigh(const MeritModel& merit, double curvature);

  /// Searches after weigh(), with its weight in `merit`. On acceptance, `trajectory` becomes the
  /// new iterate; otherwise it is unchanged.
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
  bool clamp_controls_;
  double curvature_ = 0;      ///< of the last weighed step
  double best_decrease_ = 0;  ///< of the merit, by the trials of the current step length
  std::optional<double> best_rollout_cost_;  ///< empty if the best trial is not a rollout
  Trajectory best_, trial_;
  SingleRollout rollout_;
  Evaluation evaluation_;
  Eigen::VectorXd dx_;  ///< scratch
};

}  // namespace conddp
