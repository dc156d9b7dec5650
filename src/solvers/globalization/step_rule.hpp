#pragma once

#include "solvers/common/solve_record.hpp"
#include "solvers/constraints/outer_strategy.hpp"
#include "solvers/globalization/direction.hpp"
#include "solvers/globalization/full_step_search.hpp"
#include "solvers/globalization/line_search.hpp"
#include "solvers/globalization/open_gap_search.hpp"
#include "solvers/iterate/ddp_recipe.hpp"
#include "solvers/iterate/iterate.hpp"

namespace conddp {

/// Decides on steps along the directions of a solve: a merit, the trials of a step, and what
/// earlier steps say about the next one. A rollout closes the gaps (LineSearch); with open gaps,
/// steps of all knots at once compete with it (OpenGapSearch), also for rows that the stages
/// enforce, and the full step comes first while full steps succeed (FullStepSearch).
class StepRule {
 public:
  /// The arguments must outlive the object.
  StepRule(const ShootingProblem& problem, const ControlBounds& bounds, const DdpRecipe& recipe,
           const SolverOptions& options, Iterate& iterate, OuterStrategy& outer,
           SolveRecord& record, Direction& direction);

  /// Forgets the previous solve.
  void reset();
  /// Computes the merit of the linearized iterate and writes it into the log row.
  void measure();
  /// Begins the minimization of another function at the same iterate.
  void begin_minimization();
  /// Computes slope and rounding of the merit along the direction.
  void measure_direction();
  /// Takes a step along the direction; `regularized` if its sweep was.
  bool take_step(bool regularized);
  /// Updates what the next steps use after a step from the iterate of the log row.
  void step_taken();

  const MeritModel& merit() const { return merit_; }
  /// Result of the search for the last step.
  const LineSearchResult& found() const { return found_; }
  /// True if rounding hides the merit's decrease and the stationarity does not fall either.
  bool at_rounding_floor() const { return at_rounding_floor_; }
  /// Tries again, with other derivatives.
  void leave_rounding_floor() { at_rounding_floor_ = false; }
  /// True if stages enforce equality constraints.
  bool keeps_equalities() const { return rows_; }

 private:
  bool gaps_open() const;
  void weigh_gaps();
  bool full_step_is_due(bool regularized) const;
  bool take_full_step(bool regularized);
  bool search();
  bool search_uncorrected();
  bool search_along(double first_step);
  bool blind_step_progresses();
  bool decrease_was_quadratic() const;
  double share_of_decrease() const;
  void differentiate() { iterate_.differentiate(direction_.feedback(), outer_.augmentation()); }

  const DdpRecipe& recipe_;
  const SolverOptions& options_;
  Iterate& iterate_;
  OuterStrategy& outer_;
  SolveRecord& record_;
  Direction& direction_;
  bool rows_;
  LineSearch line_search_;
  OpenGapSearch open_gap_search_;
  FullStepSearch full_step_search_;
  MeritModel merit_;
  LineSearchResult found_;
  bool by_full_step_ = false;  ///< the last step is one of FullStepSearch
  bool at_rounding_floor_ = false;
  double last_stationarity_ = 0;  ///< of the previous iterate
};

}  // namespace conddp
