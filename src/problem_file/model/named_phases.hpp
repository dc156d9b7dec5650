#pragma once

#include <optional>
#include <vector>

#include "base/text/diagnostic.hpp"
#include "problem_file/model/spec.hpp"

namespace conddp {

/// True for each phase that is named, for all phases without `names`. A name may contain `*`. Names
/// that fit no phase are reported.
std::vector<bool> phases_named(const std::optional<std::vector<Name>>& names,
                               const ProblemSpec& spec, Diagnostics& out);
/// The same without a report.
std::vector<bool> phases_named(const std::optional<std::vector<Name>>& names,
                               const ProblemSpec& spec);

/// True if a cost or constraint names a phase or one of its knots.
bool names_phase(const CostSpec& function, std::size_t phase, const ProblemSpec& spec);
/// Phases where a cost or constraint can be active: those that it names or that contain its knots,
/// by default all phases that take time. The initial choice of the state is excluded.
std::vector<bool> possible_phases(const CostSpec& function, const ProblemSpec& spec);

/// Reports phase weights for costs that do not exist.
void check_weights(const ProblemSpec& spec, Diagnostics& out);

}  // namespace conddp
