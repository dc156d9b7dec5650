#pragma once

#include <string>

#include "base/json/ordered_json.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// A problem in the form of its file, with every default filled in: weights, activations, axes,
/// phases, joints, the integrator, all options of the solver. Reading the result gives the same
/// problem, and expanding that gives the same text. Paths are relative to the file's folder, as in
/// the file. `built`: the problem built from `spec`.
OrderedJson expand_problem(const ProblemSpec& spec, const BuiltProblem& built);

/// The same as YAML, with the schema comment for editors: the file's own comment, or that of a file
/// in problems/.
std::string expanded_text(const ProblemSpec& spec, const BuiltProblem& built);

/// Warns of gait features of the closed loop that an expanded file cannot express, because phases
/// replace the gait: commands and further cycles.
void warn_of_lost_gait(const ProblemSpec& spec, Diagnostics& out);

/// The values of all solver options as nested objects by their dotted names; null: infinite.
OrderedJson expand_options(const SolverOptions& options);

}  // namespace conddp
