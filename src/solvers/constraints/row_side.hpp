#pragma once

#include <Eigen/Core>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// How a constraint row or a control bound counts in a step of Newton's method. Of a cone the first
/// row tells it.
enum class RowSide : signed char {
  lower = -1,
  inactive,
  upper,
  equality,
  surface,  ///< of a cone: one equation
  tip,      ///< of a cone: all rows vanish
  below,    ///< this and the next two: beyond what the limit of a soft constraint holds
  above,
  outside
};

/// Whether a step that goes beyond a bound by this much violates it.
bool is_violated(double beyond, double bound);

// By an iterate: values, multipliers and penalties of the rows.

/// A row of bounds.
RowSide chosen_bound(const NodeConstraint& constraint, int row, double value, double multiplier,
                     double penalty);
/// The two rows of a complementary pair. The smaller value always counts. Both count where both
/// vanish and the larger one's multiplier pushes it below zero.
void choose_pair(const double* values, const double* multipliers, const double* penalties,
                 RowSide* sides);
/// A second-order cone, whose rows share a penalty.
RowSide chosen_cone(const NodeConstraint& constraint, const double* values,
                    const double* multipliers, double penalty);
/// A control, by the gradient of the Lagrangian without its bounds.
RowSide chosen_control(double control, double lower, double upper, double gradient);

// By a step, from how they counted: values that it predicts, multipliers with its corrections.

RowSide revised_bound(const NodeConstraint& constraint, int row, RowSide side, double value,
                      double multiplier);
/// `start` are the values at the iterate, which tell whether the surface has a slope there.
RowSide revised_cone(const NodeConstraint& constraint, RowSide side, const double* start,
                     const Eigen::Ref<const Eigen::VectorXd>& values,
                     const Eigen::Ref<const Eigen::VectorXd>& multipliers);

}  // namespace conddp
