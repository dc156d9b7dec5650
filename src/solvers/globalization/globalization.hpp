#pragma once

#include <optional>

#include "solvers/common/solve_record.hpp"
#include "solvers/constraints/outer_strategy.hpp"
#include "solvers/globalization/affine_probe.hpp"
#include "solvers/globalization/direction.hpp"
#include "solvers/globalization/step_rule.hpp"
#include "solvers/iterate/control_curvature.hpp"
#include "solvers/iterate/ddp_recipe.hpp"
#include "solvers/iterate/iterate.hpp"
#include "solvers/riccati/regularization.hpp"

namespace conddp {

/// Moves a solve from one iterate to the next: sweeps give a direction, and a step along it lowers
/// a merit (StepRule), with more regularization after every failure.
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

  /// Decides on the steps.
  StepRule& rule() { return rule_; }
  const StepRule& rule() const { return rule_; }
  const Feedback& feedback() const { return direction_.feedback(); }
  /// Swaps the gains into `to`, which has their shape.
  void take_feedback(Feedback& to) { direction_.take_feedback(to); }
  /// Contradiction in the linear model of the equalities that stages enforce; 0 without such
  /// stages.
  double contradiction();

 private:
  bool find_step();
  bool prepare_direction();
  bool leave_rounding_floor();
  bool retry_regularized();
  bool sweep();
  int sweep_backward(double regularization);
  int find_direction(double regularization);
  int find_settled_direction(double regularization);
  bool found_affine();
  bool regularize_more();
  bool raise_for_unsettled();
  void correct_direction();
  bool regularisation_hides_descent();
  bool end_at_rounding_floor();
  bool end_without_step();

  const DdpRecipe& recipe_;
  const SolverOptions& options_;
  Iterate& iterate_;
  OuterStrategy& outer_;
  SolveRecord& record_;
  Direction direction_;
  StepRule rule_;
  std::optional<AffineProbe> affine_probe_;  ///< used if the model may contain rows
  ControlCurvature control_curvature_;
  RegularizationSchedule regularization_;
  const Eigen::VectorXd* multiplier_change_ = nullptr;  ///< of the last sweep's full step
  bool affine_known_ = false;                           ///< the probe has been used in this solve
};

}  // namespace conddp
