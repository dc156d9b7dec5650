#pragma once

#include <memory>

#include <Eigen/Core>

#include "ocp/evaluation/linearization.hpp"
#include "solvers/common/options.hpp"
#include "solvers/linalg/lane_matrix.hpp"
#include "solvers/riccati/gap_transport.hpp"

namespace conddp {

/// The problem in δu that the sweep meets at a knot: minimise
/// ½ δuᵀ Q_uu δu + (Q_u + Q_ux δx)ᵀ δu, where Q_uu and Q_ux may be regularised.
struct StageProblem {
  int knot;
  /// ndx x nu. Sweeps by segments have more rows: linear terms of parameters beside the state.
  Eigen::Ref<const Eigen::MatrixXd> Qxu;
  Eigen::Ref<const Eigen::MatrixXd> Quu;           ///< nu x nu
  Eigen::Ref<const Eigen::VectorXd> Qu;            ///< nu
  Eigen::Ref<const Eigen::VectorXd> u;             ///< the knot's present control
  Eigen::Ref<const Eigen::VectorXd> lower, upper;  ///< of the control, infinite where free
  int segment = 0;  ///< stages of different segments may be solved at once

  /// The right-hand side of a control i: column j of `to` (a row more than Q_xu) ← −(Q_xu; Q_uᵀ).
  void negate(int i, LaneBlock to, int j) const;
  /// The minimum without bounds, k = −Q_uu⁻¹ Q_u and K = −Q_uu⁻¹ Q_ux, by Cholesky's factorisation,
  /// for which `factor` has room; as in `StagePolicy::solve`.
  bool solve_free(LaneMatrix& factor, Eigen::Ref<Eigen::VectorXd> k, LaneBlock Kt) const;
};

/// How a solver minimises over the control of a knot. Workspaces are sized at construction; the
/// number of controls may differ between knots.
class StagePolicy {
 public:
  virtual ~StagePolicy() = default;

  /// Writes the update δu = k + K δx: `Kt` is K transposed, as large as Q_xu, and below it one more
  /// row whose content does not matter. False where the stage has no minimum, because (the free
  /// block of) Q_uu is not positive definite.
  virtual bool solve(const StageProblem& stage, Eigen::Ref<Eigen::VectorXd> k, LaneBlock Kt) = 0;
  /// Called before each sweep with what it goes through.
  virtual void begin_horizon(const Linearization& linearization, const Gaps& gaps) {
    (void)linearization, (void)gaps;
  }
  /// Called in place of `solve` at a knot without controls.
  virtual void pass(int knot) { (void)knot; }
  /// Whether K minimises the stage in all entries of the control that it does not leave alone.
  virtual bool minimizes_freely() const { return true; }
  /// Called before each sweep. With `hold` the sweep keeps the active set that `revise` left
  /// instead of finding one knot by knot.
  virtual void begin_sweep(bool hold) { (void)hold; }
  /// Shown a knot's step (δx, δu) of the last sweep's policy in the linear model, without cutting
  /// it off: holds an entry of δu that leaves its bounds there, and lets one go whose multiplier
  /// has the wrong sign. Returns how many entries changed.
  virtual int revise(int knot, const Eigen::Ref<const Eigen::VectorXd>& dx,
                     const Eigen::Ref<const Eigen::VectorXd>& du) {
    (void)knot, (void)dx, (void)du;
    return 0;
  }
  /// That the linear term Q_u of a knot is another one by `change` since the sweep met it, and the
  /// policy's k with it.
  virtual void change_gradient(int knot, const Eigen::Ref<const Eigen::VectorXd>& change) {
    (void)knot, (void)change;
  }
  /// Holds the controls of this knot at their lower bounds where `side` is negative, at their upper
  /// ones where it is positive; the others are free. After a sweep.
  virtual void assume_sides(int knot, const Eigen::Ref<const Eigen::VectorXd>& side) {
    (void)knot, (void)side;
  }
  /// Lets all controls go.
  virtual void release() {}
  /// Whether the active set holds a control at a bound.
  virtual bool holds(int knot, int i) const {
    (void)knot, (void)i;
    return false;
  }
  /// Control entries that the last sweep held at a bound, and how often entries changed their
  /// states in it and in the revisions since.
  virtual int clamped_controls() const { return 0; }
  virtual int active_set_changes() const { return 0; }
};

/// The minimum without the bounds.
std::unique_ptr<StagePolicy> unconstrained_stage(const ShootingProblem& problem);

/// k minimises the stage at δx = 0 subject to lower ≤ u + k ≤ upper; K has zero rows for clamped
/// controls (Tassa, Mansard, Todorov 2014, eqs. 9-11). Each knot starts from the active set that it
/// had in the sweep before.
///
/// That set is blind to what the knots before it do. `revise` and held sweeps alternate towards the
/// active set of the whole horizon's box-constrained QP (the primal-dual active-set method of
/// Hintermüller, Ito, Kunisch 2002, one sweep an iteration).
/// `segments`: of how many segments stages may be solved at once.
std::unique_ptr<StagePolicy> box_stage(const ShootingProblem& problem,
                                       const SolverOptions::BoxQp& options, int segments = 1);

}  // namespace conddp
