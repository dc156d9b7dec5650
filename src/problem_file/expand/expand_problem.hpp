#pragma once

#include <string>

#include "base/json/ordered_json.hpp"
#include "problem_file/assemble/build.hpp"

namespace conddp {

/// A problem in the form of its file, with every default filled in: weights, activations, axes,
/// phases, joints, the integrator, all options of the solver. Reading the result gives the same
/// problem, and expanding that gives the same text. Paths are relative to the file's folder, as in
/// the file.
OrderedJson expand_problem(const BuiltProblem& built);

/// The problem that solvers see: states, and for each phase its step, costs, constraints and
/// bounds.
OrderedJson expand_core(const BuiltProblem& built);

/// Names of the rewritings in their order (lower/rewriting.hpp), then "core", the problem as it is
/// built.
std::vector<std::string> names_of_rewritings();
/// The last rewriting, after which a problem is whole.
inline constexpr std::string_view kWholeFile = "mesh";

/// The problem after one of these. After rewritings of the specification it is whole, with
/// defaults; the numbers of a homotopy are at its end.
OrderedJson expand_after(std::string_view rewriting, const BuiltProblem& built);

/// The same as YAML, with the schema comment for editors: the file's own comment, or that of a file
/// in problems/.
std::string expanded_text(const BuiltProblem& built, std::string_view rewriting = kWholeFile);

/// Warns of gait features of the closed loop that an expanded file cannot express, because phases
/// replace the gait: commands and further cycles.
void warn_of_lost_gait(const BuiltProblem& built, Diagnostics& out);

/// The names of phases, by default of all phases that take time.
OrderedJson expand_phase_names(const std::optional<std::vector<Name>>& names,
                               const ProblemSpec& spec);

/// The values of all solver options as nested objects by their dotted names; null: infinite.
OrderedJson expand_options(const SolverOptions& options);

}  // namespace conddp
