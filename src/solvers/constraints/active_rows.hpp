#pragma once

#include <vector>

#include <Eigen/Core>

#include "ocp/evaluation/linearization.hpp"
#include "solvers/common/control_bounds.hpp"
#include "solvers/constraints/row_side.hpp"
#include "solvers/riccati/adjoint.hpp"

namespace conddp {

/// The constraints and control bounds that count as equations in a step of Newton's method: rows
/// value + A z = 0 of each node, with multipliers and what the step adds to them.
///
/// Equalities always count, and so does the smaller one of each complementary pair. Of bounds and
/// cones choose() tells by an iterate which do: those at which value plus multiplier/ρ lies outside
/// of the set. A cone counts with its surface (one row, which has curvature) or its tip (all rows).
/// revise() tells it by a step: rows that push the wrong way no longer count, and what the step
/// would violate does. A soft constraint whose multiplier is at its limit does not
/// count, but its multiplier stays in the gradients.
class ActiveRows {
 public:
  ActiveRows(const ShootingProblem& problem, const ControlBounds& bounds);

  /// By the values of an iterate, its multipliers and ρ, row by row of the problem. The multipliers
  /// of rows that do not count become zero, and those of surfaces point along them.
  void choose(const Linearization& linearization, const Eigen::VectorXd& penalty,
              Eigen::VectorXd& multipliers);
  /// Control bounds: by the gradient at controls that stand at them. After choose().
  void choose_controls(const Trajectory& trajectory, const Adjoint& adjoint);
  /// By a step of which corrections are known. False where nothing changes.
  bool revise(const Linearization& linearization, const Trajectory& trajectory,
              const Adjoint& adjoint, const Eigen::VectorXd& multipliers,
              const std::vector<Eigen::VectorXd>& step);

  /// Adds the rows' multipliers to the gradients; those of control bounds as well if asked for.
  void add_gradient(bool with_controls, Linearization& linearization) const;
  /// Adds penalty · AᵀA and the curvature of the cones' surfaces to the Hessians.
  void add_curvature(double penalty, Linearization& linearization);
  /// Corrects the multipliers by penalty times what a step leaves of the rows (before any step:
  /// forgets corrections, and adds the values). Returns the largest rest.
  double correct(double penalty, const std::vector<Eigen::VectorXd>* step,
                 Linearization& linearization);
  /// Multipliers of all constraint rows, with the corrections if asked for.
  void write_multipliers(const Linearization& linearization, bool corrected,
                         Eigen::VectorXd& multipliers) const;
  int count() const;

 private:
  enum Kind { kBounds, kConeSurface, kConeTip, kControl, kLimit };
  struct Rows {
    Rows(int rows, int nz)
        : A(Eigen::MatrixXd::Zero(rows, nz)),
          value(Eigen::VectorXd::Zero(rows)),
          multiplier(value),
          correction(value),
          source(rows),
          constraint(rows),
          kind(rows) {}

    Eigen::MatrixXd A;  ///< rows x nz, the first `count` in use, as of the others
    Eigen::VectorXd value, multiplier, correction;
    std::vector<int> source;      ///< constraint row of the problem (a cone's first), or control
    std::vector<int> constraint;  ///< index among the problem's, −1 of controls
    std::vector<Kind> kind;
    int count = 0;
  };
  void choose_sides(const NodeConstraint& c, const double* values, const double* multipliers,
                    const double* penalties);
  void predict(int node, const Linearization& linearization, const Eigen::VectorXd& step);
  bool revise_constraint(const NodeConstraint& constraint, const Linearization& linearization);
  bool revise_controls(int node, const Trajectory& trajectory, const Eigen::VectorXd& step);
  bool hold_violated_controls(int node, const Trajectory& trajectory, const Eigen::VectorXd& step);
  bool release_controls(int node);
  /// Derivative of a constraint's values by z: rows x nz.
  auto rows_of(const NodeConstraint& c, const Linearization& linearization) const {
    return linearization.knots[c.node].C.middleRows(c.row - problem_.constraint_offset(c.node),
                                                    c.term->rows);
  }
  void build(int node, const Linearization& linearization, const Eigen::VectorXd& multipliers);
  void add_row(Rows& rows, Kind kind, int source, int constraint, double value, double multiplier);
  void build_controls(int node, const Trajectory& trajectory, const Adjoint& adjoint);
  void build_bounds(Rows& rows, int index, const Linearization& linearization,
                    const Eigen::VectorXd& multipliers);
  void build_surface(Rows& rows, int index, const Linearization& linearization,
                     const Eigen::VectorXd& multipliers);
  void build_tip(Rows& rows, int index, const Linearization& linearization,
                 const Eigen::VectorXd& multipliers);
  void build_outside(Rows& rows, int index, const Linearization& linearization);
  void add_surface_curvature(int index, double multiplier, Linearization& linearization);
  void add_limit_curvature(const Rows& rows, int row, KnotLinearization& knot,
                           const Eigen::VectorXd& values);
  void add_outside_curvature(int index, KnotLinearization& knot, const Eigen::VectorXd& values);

  const ShootingProblem& problem_;
  const ControlBounds& bounds_;
  std::vector<Rows> rows_;                        ///< per node
  std::vector<std::vector<int>> constraints_of_;  ///< node, into problem.constraints()
  std::vector<RowSide> sides_;                    ///< of the constraint rows
  std::vector<RowSide> control_sides_;            ///< of the controls, as ControlBounds has them
  Eigen::VectorXd target_, scratch_, predicted_;
  Eigen::MatrixXd slope_, product_;  ///< of one soft cone: rows x rows, rows x columns
};

}  // namespace conddp
