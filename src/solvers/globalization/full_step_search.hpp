#pragma once

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/globalization/direction.hpp"
#include "solvers/globalization/line_search.hpp"
#include "solvers/iterate/iterate.hpp"
#include "solvers/riccati/linear_rollout.hpp"
#include "solvers/stages/gap_transport.hpp"

namespace conddp {

/// The full step of the linear model and its evaluation. All knots are evaluated at once, each from
/// its state in the model, whereas a rollout goes from knot to knot. The gaps of the step are of
/// second order. A correction moves the states by the policy's response to these gaps in the same
/// linear model, which leaves gaps of third order. This is a second-order correction for the
/// Maratos effect (Nocedal, Wright, section 18.3). Every further correction reduces the gaps by
/// another factor of the step's length.
class FullStep {
 public:
  FullStep(const ShootingProblem& problem, const ControlBounds& bounds);

  /// Mode of a trial: evaluation, or differentiation at once because the trajectory will be the
  /// next iterate. The derivatives then overwrite those of the previous iterate.
  enum class Trial { evaluate, differentiate };

  /// Moves a trajectory by the step and evaluates it there. `linearization` is the one before the
  /// step.
  void take(Evaluator& evaluator, const LinearRollout& step, Trial trial,
            Linearization& linearization, Trajectory& trajectory,
            const Augmentation* augmentation = nullptr);
  /// Closes the gaps to first order and evaluates the trajectory again. `linearization` is the one
  /// before the step, or that of the trajectory if it has been differentiated.
  void correct(Evaluator& evaluator, const Feedback& feedback, Trial trial,
               Linearization& linearization, Trajectory& trajectory,
               const Augmentation* augmentation = nullptr);

  /// Cost of the trial, including the augmentation if any.
  double cost() const { return evaluation_.cost.sum() + evaluation_.augmentation.sum(); }
  const Eigen::MatrixXd& gap() const { return evaluation_.gap; }

 private:
  const ControlBounds& bounds_;
  StateManifold manifold_;
  Evaluation evaluation_;
  Gaps gaps_;
  LinearRollout response_;
};

/// Tries the full step of the linear model with second-order corrections (FullStep) instead of a
/// rollout, as long as full steps succeed. The remaining gaps are judged by the cost of closing
/// them, to first order Σ λᵀ gap: the merit's ν Σ‖gap‖₁ would reject good steps near the optimum.
class FullStepSearch {
 public:
  FullStepSearch(const ShootingProblem& problem, const ControlBounds& bounds,
                 const SolverOptions::Tolerances& tolerances);

  /// Prepares a solve.
  void reset();
  /// True if enough full steps have succeeded.
  bool due() const { return full_steps_ >= wanted_; }
  /// Records whether a full step with an accurate model led to the iterate.
  void step_taken(bool full) { full_steps_ = full ? full_steps_ + 1 : 0; }

  /// Requirements on a step.
  struct Goal {
    bool last = false;   ///< it should be the last one, so its gaps must close
    bool close = false;  ///< gaps must close in any case
  };
  /// Tries the step from iterate.before. On acceptance, the trajectory is the new iterate, which
  /// may already be differentiated; otherwise the caller must undo the step.
  LineSearchResult run(Iterate& iterate, const MeritModel& merit, const Direction& direction,
                       const Augmentation* augmentation, const Goal& goal);
  /// Records that the step of the last run() is rejected.
  void reject();

 private:
  /// A step under trial, with the result of its last trial.
  struct Search {
    Iterate& iterate;
    const Direction& direction;
    const Augmentation* augmentation;
    double expected = 0;    ///< expected decrease
    bool hidden = false;    ///< rounding hides the decrease
    bool close = false;     ///< gaps are judged by their size, not by their weight
    double negligible = 0;  ///< size or weight below which gaps stay uncorrected
    double weight = 0, gap = 0;
    bool ahead = false;  ///< the trial has been differentiated

    auto costates() const {
      return iterate.adjoint.costates().rightCols(iterate.trajectory.knots());
    }
    double size() const { return close ? gap : weight; }
    bool gaps_negligible() const { return size() <= negligible; }
    bool suffices(double actual_decrease, const MeritModel& merit) const;
  };
  Search begin(Iterate& iterate, const MeritModel& merit, const Direction& direction,
               const Augmentation* augmentation, const Goal& goal) const;
  void try_point(Search& search, bool at_last, bool correct);
  void correct(Search& search);

  SolverOptions::Tolerances tolerances_;
  FullStep step_;
  int full_steps_ = 0;                ///< number of consecutive full steps
  int wanted_ = 1;                    ///< number required before this search is tried
  bool last_ = false;                 ///< Goal::last of the last run()
  bool needs_no_correction_ = false;  ///< the last step needed no correction
  double correction_leaves_ = 0;      ///< share of the gaps that the last correction left
};

}  // namespace conddp
