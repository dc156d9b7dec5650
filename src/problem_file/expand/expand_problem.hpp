#pragma once

#include <string>

#include "base/json/ordered_json.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// A problem in the shape of its file with every default filled in as it is used: weights,
/// activations, axes, phases, joints, the integrator, all options of the solver. Reading it gives
/// the same problem, and expanding that the same text. Paths are those of the file, relative to its
/// folder. `built` is what `spec` was built into.
OrderedJson expand_problem(const ProblemSpec& spec, const BuiltProblem& built);

/// The same as YAML with the line that editors find the schema by: the file's own one, or that of a
/// file in problems/.
std::string expanded_text(const ProblemSpec& spec, const BuiltProblem& built);

/// Warns of what the closed loop of a file has of its gait and an expanded file cannot say, because
/// phases stand there in place of the gait: commands, and further cycles.
void warn_of_lost_gait(const ProblemSpec& spec, Diagnostics& out);

/// The values of all solver options by their dotted names as nested objects; null: infinite.
OrderedJson expand_options(const SolverOptions& options);

}  // namespace conddp
