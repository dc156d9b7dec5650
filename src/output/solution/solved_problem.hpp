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

/// The problem of a former solution, rebuilt from the files that it names.
struct SolvedProblem {
  std::unique_ptr<const ProblemSpec> spec;
  BuiltProblem built;
};

/// Kind of document whose problem is rebuilt. The initial guess affects a loop, but not the answer
/// of a solve.
enum class RebuiltFor { kSolution, kLoop };

/// Callback that rebuilds a problem: takes the spec and the names of dropped constraints, and
/// returns the files that it has read; empty with errors.
using BuildAgain = std::function<std::optional<InputFiles>(
    ProblemSpec spec, const std::vector<std::string>& drop, Diagnostics& out)>;

/// Rebuilds the problem of a document (at least its `problem` and `dropped_constraints`) with its
/// command-line settings. `problem` is the present path of the problem file. If empty, the path in
/// the document applies, relative to the working directory or to a folder above the document.
/// Changed files cause warnings. If the problem cannot be built, the messages quote only problems,
/// robots, and data whose hash the document contains. Returns false with errors. Throws
/// MalformedSolution if the document lacks keys.
bool build_again(RebuiltFor kind, const OrderedJson& document, const std::string& document_file,
                 const std::filesystem::path& problem, const BuildAgain& build, Diagnostics& out);

/// Rebuilds the problem of a solution document.
std::optional<SolvedProblem> rebuild_problem(const OrderedJson& document,
                                             const std::string& solution_file,
                                             const std::filesystem::path& problem,
                                             Diagnostics& out);

}  // namespace conddp
