#pragma once

#include <string>
#include <vector>

#include "base/json/ordered_json.hpp"
#include "problem_file/assemble/build.hpp"
#include "solvers/common/options.hpp"

namespace conddp {

/// Differences between the problem of an answer and that of its file, and the tolerances applied.
struct AnswerSettings {
  std::vector<std::string> overrides;  ///< KEY=VALUE of the command line, in order
  std::vector<std::string> dropped;    ///< names of omitted constraints
  SolverOptions options;               ///< source of the tolerances

  /// True if the problem differs from that of the file.
  bool changed() const { return !overrides.empty() || !dropped.empty(); }
};

/// Example: "tolerances beyond the defaults: constraint 0.1 (default 1e-06)"; empty without such
/// tolerances.
std::string loose_tolerances_line(const SolverOptions& options);

/// Settings of a solution or closed loop (at least its `problem`), whose problem has been rebuilt.
/// Throws MalformedSolution if the document lacks keys.
AnswerSettings answer_settings(const OrderedJson& document, const BuiltProblem& built);

/// One line each: "setting KEY=VALUE", "dropped NAME" and loose_tolerances_line().
std::vector<std::string> settings_lines(const AnswerSettings& settings);

/// The objects of schemas/verify.schema.json: `overrides`, `dropped_constraints`,
/// `loose_tolerances`.
OrderedJson settings_json(const AnswerSettings& settings);

}  // namespace conddp
