#pragma once

#include <chrono>
#include <memory>
#include <optional>

#include "ocp/acts.hpp"
#include "solvers/adjoint.hpp"
#include "solvers/affine_probe.hpp"
#include "solvers/augmentation_change.hpp"
#include "solvers/augmented_lagrangian.hpp"
#include "solvers/direction.hpp"
#include "solvers/equality_search.hpp"
#include "solvers/hessian_switch.hpp"
#include "solvers/line_search.hpp"
#include "solvers/model_step.hpp"
#include "solvers/open_gap_search.hpp"
#include "solvers/options.hpp"
#include "solvers/plain_adjoint.hpp"
#include "solvers/projected_newton.hpp"
#include "solvers/regularization.hpp"
#include "solvers/solve_result.hpp"

namespace conddp {

/// The choices that make one solver of the family.
struct DdpRecipe {
  bool open_gaps = false;       ///< multiple shooting: start from the states given, contract gaps
  bool clamp_controls = false;  ///< the rollout projects every control on its bounds
  bool box_stage = false;       ///< stage problems respect the bounds
  bool constraints = false;     ///< constraints enter as an augmented Lagrangian
  MultiplierSchedule multipliers = MultiplierSchedule::always;
  bool newton = false;  ///< which a projected Newton method ends
  bool legs = false;    ///< sweeps may go by legs
  /// Exact second derivatives wait until the gaps are closed.
  HessianUse hessian = HessianUse::gauss_newton;
};

/// The loop of all DDP solvers: differentiate, test convergence, sweep backward, search along the
/// rollout, accept, record. Everything is allocated by the constructor.
class DdpSolver {
 public:
  DdpSolver(const ShootingProblem& problem, const DdpRecipe& recipe, const SolverOptions& options);

  SolveResult solve(const Trajectory& guess);

 private:
  bool start(const Trajectory& guess);
  void iterate();
  bool linearize();
  void measure_iterate();
  void differentiate();
  bool converged();
  bool may_continue();
  bool budget_left();
  void finish();
  void end_log();
  void confirm_status();
  void sweep_for_gains();

  // ddp_step.cpp
  bool try_step();
  bool take_step();
  bool sweep_with_regularization();
  int sweep_backward(double regularization);
  void correct_direction();
  void measure_direction();
  void weigh_gaps();
  bool model_step();
  bool search();
  bool gaps_open() const {
    return recipe_.open_gaps && !equality_search_ && gaps_.norm() > options_.tolerances.gap;
  }
  bool raise_for_unsettled();
  bool regularisation_hides_descent();
  bool blind_step_progresses();
  bool decrease_was_quadratic(bool by_model);
  double projected_stationarity() const;

  // ddp_constraints.cpp
  void start_constraints();
  void fit_penalties();
  void measure_constraints();
  double soft_cost() const;
  bool inner_converged() const;
  bool next_multipliers();
  void change_augmentation();
  bool minimized() const;
  bool hidden_by_rounding() const;
  void name_contradiction();
  bool confirmed();
  std::optional<double> reduced_stationarity();
  bool newton_converges();
  bool recover();

  // These return false, so that the step in which the solve ends can return their value.
  bool end(SolveStatus status, std::string message);
  bool end_diverged();
  bool end_without_step(bool descent);
  std::string residual_text() const;
  double elapsed() const;

  const ShootingProblem& problem_;
  DdpRecipe recipe_;
  SolverOptions options_;
  ControlBounds bounds_;
  Acts acts_;
  Linearization linearization_;
  HessianSwitch hessian_;
  Gaps gaps_;
  Adjoint adjoint_;
  Adjoint free_adjoint_;  ///< along no_feedback_
  Feedback no_feedback_;
  Direction direction_;
  LineSearch line_search_;
  OpenGapSearch open_gap_search_;
  std::optional<EqualitySearch> equality_search_;  ///< where stages keep equalities
  ModelStep model_step_;
  RegularizationSchedule regularization_;
  std::optional<AugmentedLagrangian> constraints_;
  const Augmentation* augmentation_ = nullptr;
  std::optional<Augmentation> former_augmentation_;  ///< the one before the last update
  std::optional<AugmentationChange> augmentation_change_;
  std::optional<AffineProbe> affine_probe_;  ///< where there are constraints
  bool affine_known_ = false;                ///< that has been asked in this solve
  std::optional<ProjectedNewton> newton_;
  std::optional<PlainAdjoint> plain_adjoint_;  ///< where there are constraints
  double stationarity_goal_ = 0;               ///< below its tolerance where that was not enough
  const Eigen::VectorXd* multiplier_change_ = nullptr;  ///< of the last sweep's full step
  double newton_threshold_ = 0;  ///< violation and stationarity below which Newton is tried
  bool by_newton_ = false;       ///< the solve ended with it
  bool log_is_stale_ = false;    ///< the last row of the log is not that of the iterate
  double inner_tolerance_ = 0, inner_decrease_ = 0;  ///< of the minimisation that is under way
  double dual_gain_ = 0;                             ///< ConstraintNorms::dual_gain
  int recoveries_ = 0;                               ///< minimisations that ended without a step
  int relaxations_ = 0;             ///< of penalties whose rounding hid the stationarity
  int inner_start_ = 0;             ///< iteration at which it began
  Trajectory trajectory_;           ///< the iterate
  Trajectory step_start_;           ///< what the step under way began with
  Trajectory before_;               ///< the iterate before the last step, should that be taken back
  bool stepping_ = false;           ///< a step is under way that began at step_start_
  bool abandoned_ = false;          ///< an iteration was given up half-way
  bool linearized_ = false;         ///< linearization_ belongs to trajectory_
  bool differentiated_ = false;     ///< its dynamics and costs do, the rest is still to be found
  bool at_rounding_floor_ = false;  ///< the merit is blind and stationarity does not fall
  int full_steps_ = 0;              ///< accepted one after the other
  int full_steps_wanted_ = 1;       ///< before the linear model's step is tried
  bool first_look_suffices_ = false;  ///< the last model step needed no correction
  double correction_leaves_ = 0;      ///< share of the gaps, at the last correction
  double last_stationarity_ = 0;      ///< of the iterate before
  MeritModel merit_;
  LineSearchResult search_;
  IterationRecord row_;
  SolveResult result_;
  std::chrono::steady_clock::time_point began_;
};

}  // namespace conddp
