#pragma once

#include <vector>

#include "ocp/terms/constraint.hpp"

namespace conddp {

/// A free duration in the states of a knot.
struct DurationColumn {
  int state;       ///< number of the state that is it, s
  int tangent;     ///< the tangent coordinate of that
  double written;  ///< the duration of the file, s
};

/// The rows of a constraint that is soft by its distance, as knots have them whose costs grow with
/// a free duration T: a bound b of a row g becomes the row T/written (g − b), whose distance from
/// zero grows with T as the cost has to. So limits of multipliers stay numbers of the problem.
struct RowsByDuration {
  std::vector<int> rows;             ///< of the constraint
  std::vector<double> offsets;       ///< b of each; zeros of a cone
  std::vector<double> lower, upper;  ///< their bounds; none of a cone
};

/// Of a constraint with so many rows and these bounds, a number a row each (none of a cone): rows
/// between two bounds become two, rows without any are left out.
RowsByDuration rows_by_duration(ConstraintKind kind, int rows, const std::vector<double>& lower,
                                const std::vector<double>& upper);

/// The constraint with these rows, at least one: `by_duration`, with the parameters of its residual
/// followed by the offsets. Throws std::invalid_argument where it is not soft by its distance, or
/// is too large.
ConstraintTerm by_duration(const ConstraintTerm& term, const RowsByDuration& rows,
                           const DurationColumn& duration);

}  // namespace conddp
