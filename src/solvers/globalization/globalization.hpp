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

/// Moves a solve from one iterate to the next: sweeps give a direction, and a step along it lowers
/// a merit, with more regularization after every failure. The gaps determine the search:
/// OpenGapSearch for open gaps, LineSearch for closed ones, FullStepSearch while full steps
/// succeed, and EqualitySearch if stages enforce equalities.
class Globalization {
 public:
  /// The arguments must outlive the object.
  Globalization(const ShootingProblem& problem, const ControlBounds& bounds,
                const DdpRecipe& recipe, const SolverOptions& options, Iterate& iterate,
                OuterStrategy& outer, SolveRecord& record);

  /// Prepares a solve. After this number of sweeps, searches for active sets and for regularized
  /// directions end.
  void reset(int sweeps);
  /// Exchanges memory with another problem's globalization, before both begin a solve.
  void exchange_memory(Globalization& other) { direction_.exchange_memory(other.direction_); }
  /// Computes the merit of the linearized iterate and writes it into the log row.
  void measure();
  /// Begins the minimization of another function at the same iterate.
  void begin_minimization();
  /// Takes one step. False, with the status in the record, if no step is found or the solve ends.
  bool step();
  /// Decrease of the cost by a full step without regularization in the quadratic model; 0 if the
  /// model lacks a minimum.
  double newton_gain();
  /// Computes the gains of the iterate itself, without regularization if possible. Returns the
  /// regularization used, or nothing if no sweep succeeds.
  std::optional<double> find_gains();

  const Feedback& feedback() const { return direction_.feedback(); }
  /// Result of the search for the last step.
  const LineSearchResult& found() const { return search_; }
  /// Swaps the gains into `to`, which has their shape.
  void take_feedback(Feedback& to) { direction_.take_feedback(to); }
  const MeritModel& merit() const { return merit_; }
  /// True if rounding hides the merit's decrease and the stationarity does not fall either.
  bool at_rounding_floor() const { return at_rounding_floor_; }
  /// True if stages enforce equality constraints.
  bool keeps_equalities() const { return equality_search_.has_value(); }
  /// Contradiction in the linear model of the equalities that stages enforce; 0 without such
  /// stages.
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
  std::optional<EqualitySearch> equality_search_;  ///< used if stages enforce equalities
  std::optional<AffineProbe> affine_probe_;        ///< used if the model may contain rows
  ControlCurvature control_curvature_;
  RegularizationSchedule regularization_;
  MeritModel merit_;
  LineSearchResult search_;
  const Eigen::VectorXd* multiplier_change_ = nullptr;  ///< of the last sweep's full step
  bool affine_known_ = false;                           ///< the probe has been used in this solve
  bool at_rounding_floor_ = false;
  double last_stationarity_ = 0;  ///< of the previous iterate
};

}  // namespace conddp
