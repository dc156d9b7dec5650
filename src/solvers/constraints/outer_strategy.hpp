#pragma once

#include "ocp/problem/augmentation.hpp"
#include "solvers/common/dual_guess.hpp"
#include "solvers/common/solve_record.hpp"
#include "solvers/iterate/iterate.hpp"
#include "solvers/iterate/merit_model.hpp"

namespace conddp {

/// What surrounds the minimisations of a solve: which function they minimise, when one of them is
/// done, and what the next one minimises. Without constraints there is one minimisation, of the
/// cost, and this class says so.
class OuterStrategy {
 public:
  virtual ~OuterStrategy() = default;

  /// What the function is made of beside the costs; null where nothing is.
  virtual const Augmentation* augmentation() const { return nullptr; }
  /// Multipliers of all constraint rows at the iterate that was measured last; null without them.
  virtual const Eigen::VectorXd* multipliers() const { return nullptr; }

  /// Before a solve, with multipliers to start from where there are some.
  virtual void start(const DualGuess* /*known*/) {}
  /// At the first iterate, linearised: penalties that fit its values. Returns whether the
  /// linearisation belongs to others now.
  virtual bool fit(Iterate& /*iterate*/) { return false; }
  /// What constraints cost that no evaluation knows of.
  virtual double soft_cost(const Iterate& /*iterate*/) const { return 0; }
  /// Writes violation, complementarity and penalty of a linearised iterate into a row of the log.
  virtual void measure(const Iterate& iterate, IterationRecord& row);

  /// Whether the solve is done, by the last row of the log; `stationarity` is what that may be.
  virtual bool solved(const IterationRecord& row, const SolverOptions::Tolerances& tolerances,
                      double stationarity) const;
  /// Whether the present minimisation is done, by the last row of the log.
  virtual bool minimized(const IterationRecord& /*row*/, const MeritModel& /*merit*/) const {
    return false;
  }
  /// Ends a minimisation, and puts the iterate's derivatives to those of the next function.
  /// `stuck`: rounding of the merit hides what steps gain. False, with the status, where the solve
  /// ends.
  virtual bool update(Iterate& iterate, const Feedback& feedback, const MeritModel& merit,
                      bool stuck, SolveRecord& record);
  /// Whether a minimisation in which no step was found may end all the same.
  virtual bool recovers(const SolveRecord& /*record*/, bool /*stuck*/) { return false; }
  /// Takes multipliers that were found otherwise.
  virtual void adopt(const Eigen::VectorXd& /*multipliers*/) {}
  /// That a step of this length has been taken whose sweep changes multipliers by `change`.
  virtual void add(const Eigen::VectorXd& /*change*/, double /*step*/) {}
};

}  // namespace conddp
