#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/json/ordered_json.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// The problem of a former solution, built again from the files that it names.
struct SolvedProblem {
  std::unique_ptr<const ProblemSpec> spec;
  BuiltProblem built;
};

/// Builds the problem that the document of a solution (at least its `problem` and
/// `dropped_constraints`) was made from, with the settings of its command line. `problem`: where
/// the problem file is now; empty: where the solution says, seen from here or from a folder above
/// the solution. Files that have changed since are warned of. Where the problem cannot be built,
/// nothing is quoted of files that the document names and that are neither problems nor robots nor
/// data whose hash it has. Throws MalformedSolution where the document lacks keys.
std::optional<SolvedProblem> rebuild_problem(const OrderedJson& document,
                                             const std::string& solution_file,
                                             const std::filesystem::path& problem,
                                             Diagnostics& out);

}  // namespace conddp
