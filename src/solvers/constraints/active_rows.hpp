#pragma once

#include <vector>

#include <Eigen/Core>

#include "ocp/evaluation/linearization.hpp"
#include "solvers/common/control_bounds.hpp"
#include "solvers/constraints/row_side.hpp"
#include "solvers/riccati/adjoint.hpp"

namespace conddp {

/// Constraints and control bounds that act as equations in a step of Newton's method: rows value +
/// A z = 0 of each node, with multipliers and their corrections by the step.
///
/// Equalities are always active, and so is the smaller row of each complementary pair. For bounds
/// and cones, choose() decides at an iterate: they are active if value plus multiplier/ρ lies
/// outside the set. A cone is active with its surface (one row, with curvature) or its tip (all
/// rows). revise() decides by a step: it releases rows that push the wrong way, and activates rows
/// that the step would violate. A soft constraint whose multiplier is at its limit is inactive, but
/// its multiplier stays in the gradients.
class ActiveRows {
 public:
  ActiveRows(const ShootingProblem& problem, const ControlBounds& bounds);

  /// Chooses by the values of an iterate, its multipliers and ρ, row by row of the problem.
  /// Multipliers of inactive rows become zero, and those of surfaces become normal to them.
  void choose(const Linearization& linearization, const Eigen::VectorXd& penalty,
              Eigen::VectorXd& multipliers);
  /// Chooses the control bounds, after choose(), by the gradient at controls that lie at a bound.
  void choose_controls(const Trajectory& trajectory, const Adjoint& adjoint);
  /// Revises the rows by a step with known corrections. False if nothing changes.
  bool revise(const Linearization& linearization, const Trajectory& trajectory,
              const Adjoint& adjoint, const Eigen::VectorXd& multipliers,
              const std::vector<Eigen::VectorXd>& step);

  /// Adds the rows' multipliers to the gradients, those of control bounds only if requested.
  void add_gradient(bool with_controls, Linearization& linearization) const;
  /// Adds penalty · AᵀA and the curvature of the cones' surfaces to the Hessians.
  void add_curvature(double penalty, Linearization& linearization);
  /// Corrects the multipliers by penalty times the residual of the rows after a step, and returns
  /// the largest residual. Before any step, forgets the corrections and takes the values as
  /// residuals. In both cases, penalty times the residual enters the gradients.
  double correct(double penalty, const std::vector<Eigen::VectorXd>* step,
                 Linearization& linearization);
  /// Writes the multipliers of all constraint rows, with the corrections if requested.
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

    Eigen::MatrixXd A;  ///< rows x nz; only the first `count` rows are in use, also below
    Eigen::VectorXd value, multiplier, correction;
    std::vector<int> source;      ///< constraint row (a cone's first), or control
    std::vector<int> constraint;  ///< index among the problem's constraints, −1 for controls
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
  /// Derivative of a constraint's values with respect to z: rows x nz.
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
  std::vector<std::vector<int>> constraints_of_;  ///< per node, indices into problem.constraints()
  std::vector<RowSide> sides_;                    ///< of the constraint rows
  std::vector<RowSide> control_sides_;            ///< of the controls, as in ControlBounds
  Eigen::VectorXd target_, scratch_, predicted_;
  Eigen::MatrixXd slope_, product_;  ///< for one soft cone: rows x rows, rows x columns
};

}  // namespace conddp
