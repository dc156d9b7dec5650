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

/// Whether a cost or constraint names a phase, or one of its knots.
bool names_phase(const CostSpec& function, std::size_t phase, const ProblemSpec& spec);
/// Where it can be on: in the phases that it names or in which its knots lie, by default in all
/// that take time. Never where the initial state is chosen.
std::vector<bool> possible_phases(const CostSpec& function, const ProblemSpec& spec);

/// Reports weights that phases give to costs that there are not, and knots of costs and constraints
/// that lie in none of the phases that these name.
void check_phases(const ProblemSpec& spec, Diagnostics& out);

}  // namespace conddp
