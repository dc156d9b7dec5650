#pragma once

#include "base/text/diagnostic.hpp"
#include "problem_file/spec/spec.hpp"

namespace conddp {

/// About how many constraints a knot has, and rows of these.
struct ConstraintCount {
  double constraints = 0, rows = 0;
};
ConstraintCount count_constraints(const ProblemSpec& spec, int ndx, int nu);

/// About how many bytes solving a problem takes: ndx tangent and nu control dimensions, running
/// costs and constraints. Fitted to what the solvers were seen to use, outputs included; exact to
/// some 30 %.
double memory_need(double knots, int ndx, int nu, std::size_t costs,
                   const ConstraintCount& constraints = {});

/// Bytes that this process can have at most: those of the machine, or of its limits.
double memory_there();
inline constexpr double kGiB = 1 << 30;

/// Reports an error at the phases if the problem does not fit into this machine's memory, or into
/// what the process may use of it.
void check_memory(const ProblemSpec& spec, int ndx, int nu, Diagnostics& out);

}  // namespace conddp
