#pragma once

#include "base/text/diagnostic.hpp"
#include "problem_file/model/spec.hpp"

namespace conddp {

/// Approximate numbers of constraints and constraint rows per knot.
struct ConstraintCount {
  double constraints = 0, rows = 0;
};
ConstraintCount count_constraints(const ProblemSpec& spec, int ndx, int nu);

/// Approximate memory for solving a problem, bytes. `ndx`, `nu`: tangent and control dimensions;
/// `costs`: number of running costs. Fitted to the measured use of the solvers, outputs included;
/// accurate to about 30 %.
double memory_need(double knots, int ndx, int nu, std::size_t costs,
                   const ConstraintCount& constraints = {});

/// Memory available to this process, bytes: that of the machine, or of its limits.
double memory_there();
inline constexpr double kGiB = 1 << 30;

/// Reports an error at the phases if the problem does not fit into this machine's memory, or into
/// the process limit.
void check_memory(const ProblemSpec& spec, int ndx, int nu, Diagnostics& out);

}  // namespace conddp
