#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "ocp/problem/problem.hpp"
#include "solvers/common/control_bounds.hpp"
#include "solvers/stages/box_qp.hpp"
#include "solvers/stages/stage_problem.hpp"

namespace conddp {

/// Controls of a horizon that are held at their bounds. Stages find the set knot by knot
/// (box_stage), or a sweep holds it fixed. Alternating `revise` and held sweeps approach the active
/// set of the horizon's box-constrained QP (the primal-dual active-set method of Hintermüller, Ito,
/// Kunisch 2002, with one sweep per iteration).
class ActiveSet {
 public:
  /// For stages without held controls.
  ActiveSet() = default;
  /// All controls free.
  explicit ActiveSet(const ShootingProblem& problem);

  /// Prepares a sweep. With `hold`, stages leave the set as it is.
  void begin_sweep(bool hold);
  bool is_held() const { return hold_; }

  /// Revises a knot by its step (δx, δu) in the linear model under the last sweep's policy, without
  /// clamping. Holds an entry of δu that leaves its bounds, and frees a held entry whose multiplier
  /// has the wrong sign. Returns the number of changed entries.
  int revise(int knot, const Eigen::Ref<const Eigen::VectorXd>& dx,
             const Eigen::Ref<const Eigen::VectorXd>& du);
  /// Holds the controls of this knot at their lower bounds where `side` is negative and at their
  /// upper bounds where it is positive. The others are free. To be called after a sweep.
  void assume_sides(int knot, const Eigen::Ref<const Eigen::VectorXd>& side);
  /// Holds the controls at a bound that a descent along the gradient (stacked over all controls)
  /// would cross, and the controls whose bounds coincide. The others are free.
  void assume_pushed_out(const ControlBounds& bounds, const Eigen::VectorXd& gradient,
                         const Trajectory& trajectory);
  /// Frees all controls.
  void release();

  bool holds(int knot, int i) const;
  bool holds_any(int knot) const;
  /// Number of held control entries, and number of entries that changed state in the last sweep and
  /// in the revisions since.
  int clamped_controls() const;
  int changes() const { return changes_; }

  /// For stages: `states` returns the modifiable states of a knot's controls. `bound` takes the
  /// bounds of δu from the stage. `remember` stores the data that `revise` needs if the stage holds
  /// a control.
  std::span<BoundState> states(int knot) { return knots_[knot].states; }
  void bound(const StageProblem& stage);
  const Eigen::VectorXd& lower(int knot) const { return knots_[knot].lower; }
  const Eigen::VectorXd& upper(int knot) const { return knots_[knot].upper; }
  void remember(const StageProblem& stage);
  void count_changes(int count) { changes_ += count; }

 private:
  /// Data of the last sweep at a knot; the bounds are those of δu.
  struct Knot {
    std::vector<BoundState> states;
    Eigen::MatrixXd Qxu, Quu;
    Eigen::VectorXd Qu, lower, upper;

    BoundState beyond(int i, double du) const;
    BoundState by_multiplier(int i, const Eigen::Ref<const Eigen::VectorXd>& dx,
                             const Eigen::Ref<const Eigen::VectorXd>& du) const;
  };

  std::vector<Knot> knots_;  ///< empty if nothing can be held
  bool hold_ = false;
  int changes_ = 0;
};

}  // namespace conddp
