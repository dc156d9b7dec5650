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
  /// A step that is tried, and how its last trial looks.
  struct Search {
    Iterate& iterate;
    const Direction& direction;
    const Augmentation* augmentation;
    double expected = 0;    ///< decrease
    bool hidden = false;    ///< by rounding
    bool close = false;     ///< gaps are judged by their size, not by what they weigh
    double negligible = 0;  ///< size or weight up to which they are left as they are
    double weight = 0, gap = 0;
    bool ahead = false;  ///< the trial has been differentiated

    auto costates() const {
      return iterate.adjoint.costates().rightCols(iterate.trajectory.knots());
    }
    double size() const { return close ? gap : weight; }
    bool gaps_negligible() const { return size() <= negligible; }
    bool hopeless() const;
    bool suffices(double actual_decrease, const MeritModel& merit) const;
  };
  Search begin(Iterate& iterate, const MeritModel& merit, const Direction& direction,
               const Augmentation* augmentation, const Goal& goal) const;
  void try_point(Search& search, bool at_last, bool correct);
  void correct(Search& search);

  SolverOptions::Tolerances tolerances_;
  FullStep step_;
  int full_steps_ = 0;                ///< taken one after the other
  int wanted_ = 1;                    ///< before this step is tried
  bool last_ = false;                 ///< Goal::last of the last run
  bool needs_no_correction_ = false;  ///< that was so of the last step
  double correction_leaves_ = 0;      ///< share of the gaps, at the last correction
};

}  // namespace conddp
