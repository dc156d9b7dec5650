#pragma once

#include <optional>

#include "solvers/common/solve_record.hpp"
#include "solvers/constraints/outer_strategy.hpp"
#include "solvers/globalization/affine_probe.hpp"
#include "solvers/globalization/direction.hpp"
#include "solvers/globalization/equality_search.hpp"
#include "solvers/globalization/full_step_search.hpp"
#include "solvers/globalization/line_search.hpp"
#include "solvers/globalization/open_gap_search.hpp"
#include "solvers/iterate/control_curvature.hpp"
#include "solvers/iterate/ddp_recipe.hpp"
#include "solvers/iterate/iterate.hpp"
#include "solvers/riccati/regularization.hpp"

namespace conddp {

/// How a solve gets from one iterate to the next: a direction by sweeps, and a step along it that
/// lowers a merit, with more regularisation after every failure. Which search finds the step
/// depends on the gaps: open ones (OpenGapSearch), closed ones (LineSearch), full steps that go
/// well (FullStepSearch), equalities that stages keep (EqualitySearch).
class Globalization {
 public:
  /// The parts that it works with live longer than it does.
  Globalization(const ShootingProblem& problem, const ControlBounds& bounds,
                const DdpRecipe& recipe, const SolverOptions& options, Iterate& iterate,
                OuterStrategy& outer, SolveRecord& record);

  /// At the start of a solve.
  void reset();
  /// Exchanges memory with another problem's, before both begin a solve.
  void exchange_memory(Globalization& other) { direction_.exchange_memory(other.direction_); }
  /// The merit of the linearised iterate, into the row of the log.
  void measure();
  /// At the start of a minimisation of another function, at the same iterate.
  void begin_minimization();
  /// One step. False, with the status in the record, where there is none or the solve ends.
  bool step();
  /// What a full step without regularization would gain of the cost in the quadratic model; 0 where
  /// that has no minimum.
  double newton_gain();
  /// The gains of the iterate itself, without regularisation if possible, and that; none where no
  /// sweep succeeds.
  std::optional<double> find_gains();

  const Feedback& feedback() const { return direction_.feedback(); }
  /// What the last step was found by.
  const LineSearchResult& found() const { return search_; }
  /// Moves the gains out; `to` has their shape.
  void take_feedback(Feedback& to) { direction_.take_feedback(to); }
  const MeritModel& merit() const { return merit_; }
  /// Whether rounding hides the merit's decrease, and the stationarity does not fall either.
  bool at_rounding_floor() const { return at_rounding_floor_; }
  /// Whether stages keep equality constraints.
  bool keeps_equalities() const { return equality_search_.has_value(); }
  /// How much equalities that stages keep contradict each other in the linear model; 0 elsewhere.
  double contradiction();

 private:
  bool find_step(bool& by_full_step);
  bool prepare_direction();
  bool try_step(bool& by_full_step, bool& descends);
  bool leave_rounding_floor();
  bool retry_regularized(bool descends);
  void step_taken(bool by_full_step);
  bool sweep();
  int sweep_backward(double regularization);
  int find_direction(double regularization);
  int find_settled_direction(double regularization);
  bool found_affine();
  bool regularize_more();
  bool raise_for_unsettled();
  void correct_direction();
  void measure_direction();
  void weigh_gaps();
  bool full_step_is_due() const;
  bool take_full_step();
  bool search(bool& descends);
  bool search_uncorrected(bool& descends);
  bool search_with_open_gaps();
  bool search_judged();
  bool search_along(double first_step);
  bool blind_step_progresses();
  bool decrease_was_quadratic(bool by_full_step);
  double share_of_decrease(bool by_full_step);
  bool regularisation_hides_descent();
  bool end_at_rounding_floor();
  bool end_without_step(bool descends);
  bool gaps_open() const;
  void differentiate() { iterate_.differentiate(feedback(), outer_.augmentation()); }

  const ShootingProblem& problem_;
  const DdpRecipe& recipe_;
  const SolverOptions& options_;
  Iterate& iterate_;
  OuterStrategy& outer_;
  SolveRecord& record_;
  Direction direction_;
  LineSearch line_search_;
  OpenGapSearch open_gap_search_;
  FullStepSearch full_step_search_;
  std::optional<EqualitySearch> equality_search_;  ///< where stages keep equalities
  std::optional<AffineProbe> affine_probe_;        ///< where the model has rows
  ControlCurvature control_curvature_;
  RegularizationSchedule regularization_;
  MeritModel merit_;
  LineSearchResult search_;
  const Eigen::VectorXd* multiplier_change_ = nullptr;  ///< of the last sweep's full step
  bool affine_known_ = false;                           ///< that has been asked in this solve
  bool at_rounding_floor_ = false;
  double last_stationarity_ = 0;  ///< of the iterate before
};

}  // namespace conddp
