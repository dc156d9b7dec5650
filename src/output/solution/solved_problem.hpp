#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/json/ordered_json.hpp"
#include "output/solution/input_files.hpp"

namespace conddp {

/// The problem of a former solution, built again from the files that it names.
struct SolvedProblem {
  std::unique_ptr<const ProblemSpec> spec;
  BuiltProblem built;
};

/// Of what kind the document is whose problem is built again. Where a solve began has no part in
/// its answer; in a loop the first guess has.
enum class RebuiltFor { kSolution, kLoop };

/// What is made of a problem again: it takes the spec and the names of dropped constraints, and
/// returns the files that it has read; nothing with errors.
using BuildAgain = std::function<std::optional<InputFiles>(
    ProblemSpec spec, const std::vector<std::string>& drop, Diagnostics& out)>;

/// Reads the problem that a document (at least its `problem` and `dropped_constraints`) was made
/// from, with the settings of its command line, and builds it. `problem`: where the problem file is
/// now; empty: where the document says, seen from here or from a folder above it. Files that have
/// changed since are warned of. Where the problem cannot be built, nothing is quoted of files that
/// the document names and that are neither problems nor robots nor data whose hash it has. False
/// with errors. Throws MalformedSolution where the document lacks keys.
bool build_again(RebuiltFor kind, const OrderedJson& document, const std::string& document_file,
                 const std::filesystem::path& problem, const BuildAgain& build, Diagnostics& out);

/// The same for the document of a solution.
std::optional<SolvedProblem> rebuild_problem(const OrderedJson& document,
                                             const std::string& solution_file,
                                             const std::filesystem::path& problem,
                                             Diagnostics& out);

}  // namespace conddp
