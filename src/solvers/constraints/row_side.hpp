#pragma once

#include <Eigen/Core>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// Role of a constraint row or a control bound in a step of Newton's method. The first row of a
/// cone gives the role of the cone.
enum class RowSide : signed char {
  lower = -1,
  inactive,
  upper,
  equality,
  surface,  ///< of a cone: a single equation
  tip,      ///< of a cone: all rows vanish
  below,    ///< this and the next two: beyond the limit of a soft constraint
  above,
  outside
};

/// True if a step that exceeds a bound by this much violates it.
bool is_violated(double beyond, double bound);

// Choices at an iterate, from values, multipliers and penalties of the rows.

/// Side of a row of bounds.
RowSide chosen_bound(const NodeConstraint& constraint, int row, double value, double multiplier,
                     double penalty);
/// Sides of the two rows of a complementary pair. The smaller value is always active. Both rows are
/// active if both values vanish and the larger one's multiplier pushes it below zero.
void choose_pair(const double* values, const double* multipliers, const double* penalties,
                 RowSide* sides);
/// Side of a second-order cone, whose rows share a penalty.
RowSide chosen_cone(const NodeConstraint& constraint, const double* values,
                    const double* multipliers, double penalty);
/// Side of a control, by the gradient of the Lagrangian without its bounds.
RowSide chosen_control(double control, double lower, double upper, double gradient);

// Revisions by a step, from the previous sides, the predicted values and the corrected multipliers.

RowSide revised_bound(const NodeConstraint& constraint, int row, RowSide side, double value,
                      double multiplier);
/// `start` holds the values at the iterate, which decide whether the surface has a slope there.
RowSide revised_cone(const NodeConstraint& constraint, RowSide side, const double* start,
                     const Eigen::Ref<const Eigen::VectorXd>& values,
                     const Eigen::Ref<const Eigen::VectorXd>& multipliers);

}  // namespace conddp
