#pragma once

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/globalization/direction.hpp"
#include "solvers/globalization/full_step.hpp"
#include "solvers/globalization/line_search.hpp"
#include "solvers/iterate/iterate.hpp"

namespace conddp {

/// The full step of the linear model with second-order corrections (FullStep) instead of a rollout,
/// as long as full steps go well. What the step leaves of gaps is judged by what closing them will
/// cost, to first order Σ λᵀ gap: the merit's ν Σ‖gap‖₁ would reject good steps near the optimum.
class FullStepSearch {
 public:
  FullStepSearch(const ShootingProblem& problem, const ControlBounds& bounds,
                 const SolverOptions::Tolerances& tolerances);

  /// At the start of a solve.
  void reset();
  /// Whether enough full steps have gone well.
  bool due() const { return full_steps_ >= wanted_; }
  /// That an iterate has been reached by a full step on which the model held, or otherwise.
  void step_taken(bool full) { full_steps_ = full ? full_steps_ + 1 : 0; }

  /// What is asked of a step.
  struct Goal {
    bool last = false;   ///< it should be the last one: its gaps have to close
    bool close = false;  ///< gaps have to close in any case
  };
  /// Tries the step from iterate.before. On acceptance the trajectory is the new iterate, whose
  /// derivatives may be known already; else it has to be taken back.
  LineSearchResult run(Iterate& iterate, const MeritModel& merit, const Direction& direction,
                       const Augmentation* augmentation, const Goal& goal);
  /// That the step of the last run() does not stand.
  void reject();

 private:
  SolverOptions::Tolerances tolerances_;
  FullStep step_;
  int full_steps_ = 0;                ///< taken one after the other
  int wanted_ = 1;                    ///< before this step is tried
  bool last_ = false;                 ///< Goal::last of the last run
  bool needs_no_correction_ = false;  ///< that was so of the last step
  double correction_leaves_ = 0;      ///< share of the gaps, at the last correction
};

}  // namespace conddp
