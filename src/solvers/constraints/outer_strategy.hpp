#pragma once

#include <memory>

#include "ocp/problem/problem.hpp"
#include "solvers/common/control_bounds.hpp"
#include "solvers/common/dual_guess.hpp"
#include "solvers/common/solve_record.hpp"
#include "solvers/iterate/iterate.hpp"

namespace conddp {

/// Controls the minimizations of a solve: which function they minimize, when each of them ends, and
/// what the next one minimizes. This base class is the case without constraints, with one
/// minimization of the cost.
class OuterStrategy {
 public:
  virtual ~OuterStrategy() = default;

  /// Terms of the function besides the costs; null without such terms.
  virtual const Augmentation* augmentation() const { return nullptr; }
  /// Multipliers of all constraint rows at the last measured iterate; null without multipliers.
  virtual const Eigen::VectorXd* multipliers() const { return nullptr; }

  /// Prepares a solve, with initial multipliers if known.
  virtual void start(const DualGuess* /*known*/) {}
  /// Fits the penalties to the values of the first, linearized iterate. True if the linearization
  /// is outdated by that.
  virtual bool fit(Iterate& /*iterate*/) { return false; }
  /// Cost of constraints that evaluations do not include.
  virtual double soft_cost(const Iterate& /*iterate*/) const { return 0; }
  /// Writes violation, complementarity and penalty of a linearized iterate into a row of the log.
  virtual void measure(const Iterate& iterate, IterationRecord& row);

  /// True if the solve is done, by the last row of the log; `stationarity` is the limit of its
  /// stationarity.
  virtual bool solved(const IterationRecord& row, const SolverOptions::Tolerances& tolerances,
                      double stationarity) const;
  /// True if the current minimization is done, by the last row of the log.
  virtual bool minimized(const IterationRecord& /*row*/, const MeritModel& /*merit*/) const {
    return false;
  }
  /// Ends a minimization, and changes the iterate's derivatives to those of the next function.
  /// `stuck`: rounding of the merit hides the gain of steps. False, with the status, if the solve
  /// ends.
  virtual bool update(Iterate& iterate, const Feedback& feedback, const MeritModel& merit,
                      bool stuck, SolveRecord& record);
  /// True if a minimization may end although no step was found.
  virtual bool recovers(const SolveRecord& /*record*/, bool /*stuck*/) { return false; }
  /// Takes the multipliers that follow from the last measured iterate. Penalties stay.
  virtual void take_multipliers() {}
  /// Takes multipliers from another source.
  virtual void adopt(const Eigen::VectorXd& /*multipliers*/) {}
  /// Records a step of this length, whose sweep changes the multipliers by `change`.
  virtual void add(const Eigen::VectorXd& /*change*/, double /*step*/) {}
};

/// The strategy of a restoration. It minimizes cost + ½ρ Σ‖d‖², where d are the distances of hard
/// constraints from their sets, and ρ grows until the outcome is clear. The strategy ends as
/// `converged` if the violation is small, and as `infeasible` at a point of least violation
/// (ViolationSlope).
std::unique_ptr<OuterStrategy> least_violation_strategy(const ShootingProblem& problem,
                                                        const ControlBounds& bounds,
                                                        const SolverOptions& options);

/// The strategy of the augmented Lagrangian, for any schedule of multipliers.
std::unique_ptr<OuterStrategy> augmented_lagrangian_strategy(const ShootingProblem& problem,
                                                             const SolverOptions& options,
                                                             MultiplierSchedule schedule);

}  // namespace conddp
