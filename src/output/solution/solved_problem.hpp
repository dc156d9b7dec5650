#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/json/ordered_json.hpp"
#include "output/solution/input_files.hpp"
#include "problem_file/assemble/build_problem.hpp"

namespace conddp {

/// The settings of the command line that made a document. Throws MalformedSolution if it lacks
/// them.
std::vector<std::string> overrides_of(const OrderedJson& document);

/// Kind of document whose problem is rebuilt. The initial guess affects a loop, but not the answer
/// of a solve.
enum class RebuiltFor { kSolution, kLoop };

/// Callback that rebuilds a problem with settings and without some constraints. Returns the files
/// that it has read; empty with errors.
using BuildAgain = std::function<std::optional<InputFiles>(
    const ProblemDocument& document, const std::vector<Setting>& settings,
    const BuildOptions& options, Diagnostics& out)>;

/// Rebuilds the problem of a document (at least its `problem` and `dropped_constraints`) with its
/// command-line settings. `problem` is the present path of the problem file. If empty, the path in
/// the document applies, relative to the working directory or to a folder above the document.
/// Changed files cause warnings. If the problem cannot be built, the messages quote only problems,
/// robots, and data whose hash the document contains. Returns false with errors. Throws
/// MalformedSolution if the document lacks keys.
bool build_again(RebuiltFor kind, const OrderedJson& document, const std::string& document_file,
                 const std::filesystem::path& problem, const BuildAgain& build, Diagnostics& out);

/// Rebuilds the problem of a solution document, with the default guess.
std::optional<BuiltProblem> rebuild_problem(const OrderedJson& document,
                                            const std::string& solution_file,
                                            const std::filesystem::path& problem, Diagnostics& out);

}  // namespace conddp
