#pragma once

#include <vector>

#include "ocp/terms/constraint.hpp"

namespace conddp {

/// A free duration in the state of a knot.
struct DurationColumn {
  int state;       ///< index of the duration in the state, s
  int tangent;     ///< tangent coordinate of `state`
  double written;  ///< duration in the file, s
};

/// Rows of an l1-soft constraint at knots whose costs scale with a free duration T. A bound b of a
/// row g becomes the row T/written (g − b), whose distance from zero scales with T as the cost
/// must. Multiplier limits therefore remain constants of the problem.
struct RowsByDuration {
  std::vector<int> rows;             ///< of the constraint
  std::vector<double> offsets;       ///< b of each row; zeros for a cone
  std::vector<double> lower, upper;  ///< bounds of the new rows; empty for a cone
};

/// Converts a constraint with this many rows and these bounds, one number per row each (none for a
/// cone). Rows between two bounds become two rows; unbounded rows are dropped.
RowsByDuration rows_by_duration(ConstraintKind kind, int rows, const std::vector<double>& lower,
                                const std::vector<double>& upper);

/// The constraint with these rows, at least one: `by_duration`, with the parameters of its residual
/// followed by the offsets. Throws std::invalid_argument if it is not l1-soft or is too large.
ConstraintTerm by_duration(const ConstraintTerm& term, const RowsByDuration& rows,
                           const DurationColumn& duration);

}  // namespace conddp
