#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "ocp/problem/problem.hpp"
#include "solvers/common/control_bounds.hpp"
#include "solvers/stages/box_qp.hpp"
#include "solvers/stages/stage_problem.hpp"

namespace conddp {

/// Which controls of a horizon are held at their bounds. Stages find it knot by knot (box_stage),
/// or a sweep holds it as it is; `revise` and held sweeps alternate towards the active set of the
/// whole horizon's box-constrained QP (the primal-dual active-set method of Hintermüller, Ito,
/// Kunisch 2002, one sweep an iteration).
class ActiveSet {
 public:
  /// Of stages that hold nothing.
  ActiveSet() = default;
  /// All controls free.
  explicit ActiveSet(const ShootingProblem& problem);

  /// Before each sweep. With `hold` stages leave the set as it is.
  void begin_sweep(bool hold);
  bool is_held() const { return hold_; }

  /// Shown a knot's step (δx, δu) of the last sweep's policy in the linear model, without clamping
  /// it: holds an entry of δu that leaves its bounds there, and lets one go whose multiplier has
  /// the wrong sign. Returns how many entries changed.
  int revise(int knot, const Eigen::Ref<const Eigen::VectorXd>& dx,
             const Eigen::Ref<const Eigen::VectorXd>& du);
  /// That the linear term Q_u of a knot is another one by `change` since the sweep met it, and the
  /// policy's k with it.
  void change_gradient(int knot, const Eigen::Ref<const Eigen::VectorXd>& change);
  /// Holds the controls of this knot at their lower bounds where `side` is negative, at their upper
  /// ones where it is positive; the others are free. After a sweep.
  void assume_sides(int knot, const Eigen::Ref<const Eigen::VectorXd>& side);
  /// Holds the controls of a trajectory that stand at a bound which a descent along the gradient
  /// (of all controls, one after the other) would cross, and those whose bounds are the same; the
  /// others are free.
  void assume_pushed_out(const ControlBounds& bounds, const Eigen::VectorXd& gradient,
                         const Trajectory& trajectory);
  /// Lets all controls go.
  void release();

  bool holds(int knot, int i) const;
  bool holds_any(int knot) const;
  /// Control entries that are held, and how often entries changed their states in the last sweep
  /// and in the revisions since.
  int clamped_controls() const;
  int changes() const { return changes_; }

  /// For stages: the states of a knot's controls, to be changed; the bounds of its δu, which
  /// `bound` takes from the stage; and what `revise` needs of a stage that holds a control.
  std::span<BoundState> states(int knot) { return knots_[knot].states; }
  void bound(const StageProblem& stage);
  const Eigen::VectorXd& lower(int knot) const { return knots_[knot].lower; }
  const Eigen::VectorXd& upper(int knot) const { return knots_[knot].upper; }
  void remember(const StageProblem& stage);
  void count_changes(int count) { changes_ += count; }

 private:
  /// What the last sweep saw at a knot; bounds are those of δu.
  struct Knot {
    std::vector<BoundState> states;
    Eigen::MatrixXd Qxu, Quu;
    Eigen::VectorXd Qu, lower, upper;

    BoundState beyond(int i, double du) const;
    BoundState by_multiplier(int i, const Eigen::Ref<const Eigen::VectorXd>& dx,
                             const Eigen::Ref<const Eigen::VectorXd>& du) const;
  };

  std::vector<Knot> knots_;  ///< none where nothing can be held
  bool hold_ = false;
  int changes_ = 0;
};

}  // namespace conddp
