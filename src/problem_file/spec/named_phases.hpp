#pragma once

#include <optional>
#include <vector>

#include "base/text/diagnostic.hpp"
#include "problem_file/spec/spec.hpp"

namespace conddp {

/// Which phases are named, all if nothing is; a name may have a `*`. Names of no phase are
/// reported.
std::vector<bool> phases_named(const std::optional<std::vector<Name>>& names,
                               const ProblemSpec& spec, Diagnostics& out);
/// The same without a report.
std::vector<bool> phases_named(const std::optional<std::vector<Name>>& names,
                               const ProblemSpec& spec);

/// Reports weights that phases give to costs that there are not, and knots of costs and constraints
/// that lie in none of the phases that these name.
void check_phases(const ProblemSpec& spec, Diagnostics& out);

}  // namespace conddp
