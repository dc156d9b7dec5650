#pragma once

#include <memory>

#include <Eigen/Core>

#include "ocp/evaluation/linearization.hpp"
#include "solvers/common/options.hpp"
#include "solvers/linalg/lane_matrix.hpp"
#include "solvers/stages/active_set.hpp"
#include "solvers/stages/gap_transport.hpp"
#include "solvers/stages/stage_problem.hpp"

namespace conddp {

/// Minimizes over the control of a knot. Workspaces are sized at construction; the number of
/// controls may differ between knots.
class StageSolver {
 public:
  StageSolver() = default;
  explicit StageSolver(ActiveSet active_set) : active_set_(std::move(active_set)) {}
  virtual ~StageSolver() = default;

  /// Writes the update δu = k + K δx. `Kt` is K transposed, as large as Q_xu, plus a last row for
  /// scratch. False if the stage lacks a minimum because Q_uu, or its free block, is not positive
  /// definite.
  virtual bool solve(const StageProblem& stage, Eigen::Ref<Eigen::VectorXd> k,
                     const LaneBlock& Kt) = 0;
  /// Called before each sweep with the linearization and gaps of its horizon.
  virtual void begin_horizon(const Linearization& linearization, const Gaps& gaps) {
    (void)linearization, (void)gaps;
  }
  /// Called in place of `solve` at a knot without controls.
  virtual void pass(int knot) { (void)knot; }
  /// True if K minimizes the stage in all control entries that it acts on.
  virtual bool minimizes_freely() const { return true; }

  /// Controls that the stages hold at bounds, for all knots.
  ActiveSet& active_set() { return active_set_; }
  const ActiveSet& active_set() const { return active_set_; }

 private:
  ActiveSet active_set_;
};

/// Minimizes without the bounds.
std::unique_ptr<StageSolver> unconstrained_stage(const ShootingProblem& problem);

/// k minimizes the stage at δx = 0 subject to lower ≤ u + k ≤ upper; K has zero rows for clamped
/// controls (Tassa, Mansard, Todorov 2014, eqs. 9-11). Each knot starts from its active set in the
/// previous sweep.
///
/// This set ignores the steps of earlier knots. Alternating `ActiveSet::revise` and held sweeps
/// approach the active set of the horizon's box-constrained QP.
std::unique_ptr<StageSolver> box_stage(const ShootingProblem& problem);

}  // namespace conddp
