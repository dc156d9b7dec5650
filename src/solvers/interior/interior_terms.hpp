#pragma once

#include <vector>

#include "ocp/evaluation/linearization.hpp"
#include "ocp/problem/problem.hpp"
#include "solvers/common/control_bounds.hpp"
#include "solvers/common/tuning.hpp"
#include "solvers/interior/interior_cone.hpp"
#include "solvers/interior/row_blocks.hpp"
#include "solvers/riccati/linear_rollout.hpp"

namespace conddp {

/// Evaluation point of constraints: a trajectory and the values of all constraint rows.
struct TermPoint {
  const Trajectory& trajectory;
  const Eigen::VectorXd& rows;
};

/// A scalar function of one node: a constraint row, an entry of the control, or the product of two
/// entries.
class ScalarTerm {
 public:
  static ScalarTerm of_row(int node, int row) { return {node, row, -1, -1}; }
  static ScalarTerm control(int node, int entry) { return {node, -1, entry, -1}; }
  static ScalarTerm product(int node, int first, int second) { return {node, -1, first, second}; }

  int node() const { return node_; }
  /// Constraint row of the problem; −1 for functions of the control.
  int row() const { return row_; }
  int entry() const { return entry_; }
  bool is_control() const { return row_ < 0 && partner_ < 0; }
  bool is_product() const { return partner_ >= 0; }

  double value(const TermPoint& at) const;
  /// Derivative along a step that changes the constraint rows by `rows`.
  double slope(const Eigen::VectorXd& rows, const Trajectory& at, const LinearRollout& step) const;
  /// Adds factor · ∂g/∂z to the gradient of the node, or the factor to that of the row.
  void add_gradient(const Trajectory& at, double factor, Eigen::VectorXd& rows,
                    Linearization& to) const;
  /// Adds factor · (∂g/∂z)ᵀ ∂g/∂z to the Hessian of the node, or the factor to that of the row.
  void add_square(const Trajectory& at, double factor, Eigen::VectorXd& rows,
                  std::vector<Eigen::MatrixXd>& to) const;

 private:
  ScalarTerm(int node, int row, int entry, int partner)
      : node_(node), row_(row), entry_(entry), partner_(partner) {}

  int node_, row_, entry_, partner_;
};

/// Constraints of a problem as a primal-dual interior-point method sees them.
///
/// Inequalities σ (g − b) + p ≥ 0 have slacks s and multipliers ν with s ν = μ. Hard ones have p =
/// 0; those that are soft by their distance have p ≥ 0 with p (w − ν) = μ for their weight w.
/// Control bounds are inequalities whose slack is their distance. Equalities c = 0 have multipliers
/// y, and a step satisfies c + C δz = δy/ρ with a large ρ: redundant equations are harmless then.
/// Cones are those of InteriorCone. Eliminating slacks and multipliers adds terms to gradients and
/// Hessians of the nodes, so that the sweep of an unconstrained problem computes the step.
///
/// Complementary pairs 0 ≤ z ⊥ s ≥ 0 are relaxed to z ≥ 0, s ≥ 0 and z s ≤ ε, where ε falls with
/// the barrier (Scholtes 2001; Raghunathan, Biegler 2005). In the end, the smaller entry of each
/// pair is held at 0.
class InteriorTerms {
 public:
  InteriorTerms(const ShootingProblem& problem, const ControlBounds& bounds);

  /// Moves the controls inside of their bounds, by this relative distance.
  void enter(Trajectory& trajectory, double inside = tuning::interior::kInside) const;
  /// Sets slacks and multipliers at a point, with slacks of at least the size `inside`.
  /// `relaxation` is ε.
  void start(const TermPoint& at, double mu, double relaxation,
             double inside = tuning::interior::kInside);
  /// Takes multipliers of equations from those of all constraint rows of the problem.
  void take_equation_multipliers(const Eigen::VectorXd& multipliers);
  /// μ.
  double barrier() const { return mu_; }
  double relaxation() const { return relaxation_; }
  /// Lowers μ, and ε in proportion.
  void set_barrier(double mu) {
    relaxation_ *= mu / mu_;
    mu_ = mu;
  }
  bool has_pairs() const { return !pairs_.empty(); }
  bool has_free_pairs() const { return relaxation_ > 0; }
  /// Holds the smaller entry of each pair at 0 from now on.
  void hold_pairs(Trajectory& trajectory);

  /// Writes the multipliers of the problem's rows, for the Lagrangian of the rows.
  void write_row_multipliers(Eigen::VectorXd& multipliers) const;
  /// Adds the multipliers of all other terms to the gradients.
  void add_multipliers(const Trajectory& at, Linearization& to);
  /// Multipliers of the problem's constraints, pairs included.
  void write_multipliers(const Trajectory& at, Eigen::VectorXd& multipliers) const;

  /// Computes the residuals of all terms at a point.
  void measure(const TermPoint& at);
  /// Adds the condensed terms to the gradients.
  void add_gradients(const Trajectory& at, Linearization& to);
  /// Computes the condensed terms of the Hessians.
  void condense(const Trajectory& at, const Linearization& linearization);
  /// Adds them to the nodes' Hessians, with the pairs' curvature ν δz δs: all of it or, with
  /// `convex`, as much as leaves the pair's own terms convex.
  void add_hessians(const Trajectory& at, bool convex, std::vector<Eigen::MatrixXd>& to) const;

  /// Computes the steps of slacks and multipliers from that of the trajectory.
  StepLimits expand(const Linearization& linearization, const Trajectory& at,
                    const LinearRollout& step);
  /// Derivative of the barrier function along the step; `slope` is that of the Lagrangian.
  double barrier_slope(double slope) const;
  /// Sets the slacks of a trial, a step of this length from the saved ones.
  void move(double length, const Trajectory& trial);
  void save();
  void restore();
  /// Updates the multipliers after a step.
  void accept(double primal, double dual);

  /// Barrier function of the present slacks at a cost.
  double barrier_function(double cost) const;
  /// ℓ1 norm of the residuals at a point.
  double infeasibility(const TermPoint& at) const;
  double largest_residual() const;
  /// Largest distance of a product of slack and multiplier from μ.
  double off_center() const;
  /// Mean size of the multipliers.
  double mean_multiplier() const;
  /// Sets ρ, the penalty of the equalities.
  void set_penalty(double penalty) { penalty_ = penalty; }
  /// Puts controls on bounds that are closer than their multiplier.
  void snap(Trajectory& trajectory) const;

 private:
  struct Side {
    ScalarTerm term;
    double sign;
    const double *bound_now, *limit_now;  ///< in the problem, which may change between solves
    double bound = 0, limit = 0;
    bool active = true;
    double s = 1, nu = 1, p = 0, q = 0;  ///< slack, multiplier, elastic part, w − ν
    double residual = 0, width = 1, push = 0;
    double along = 0, ds = 0, dnu = 0, dp = 0;
    bool is_soft() const;
  };
  struct Equality {
    ScalarTerm term;
    const double* target_now;  ///< likewise
    double target = 0;
    double residual = 0, y = 0, along = 0, dy = 0;
  };
  struct Pair {
    int node, row;      ///< first constraint row
    int first, second;  ///< entries of the control
    int side;           ///< of the product; those of the entries follow
    int fixed = -1;     ///< equality that holds one of them at 0
    bool holds_first = false;
  };
  void collect(const NodeConstraint& constraint);
  void collect_pairs(const NodeConstraint& constraint);
  void collect_bounds(const ControlBounds& bounds);
  double value(const Side& side, const TermPoint& at) const;
  void prepare(Side& side) const;

  const ShootingProblem& problem_;
  const ControlBounds& bounds_;
  RowBlocks rows_;
  Eigen::VectorXd factors_, along_;         ///< of constraint rows
  std::vector<Eigen::MatrixXd> condensed_;  ///< terms of the Hessians by node
  std::vector<Side> sides_, saved_;
  std::vector<Equality> equalities_;
  std::vector<Pair> pairs_;
  std::vector<InteriorCone> cones_;
  double mu_ = 1, relaxation_ = 1, penalty_ = 1;
};

}  // namespace conddp
