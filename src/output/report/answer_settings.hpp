#pragma once

#include <string>
#include <vector>

#include "base/json/ordered_json.hpp"
#include "problem_file/build/build.hpp"
#include "solvers/common/options.hpp"

namespace conddp {

/// By what the problem of an answer differs from that of its file, and by which tolerances it was
/// judged.
struct AnswerSettings {
  std::vector<std::string> overrides;  ///< KEY=VALUE of the command line, in its order
  std::vector<std::string> dropped;    ///< names of constraints that were left out
  SolverOptions options;               ///< whose tolerances count

  /// Whether the problem is another one than that of the file.
  bool changed() const { return !overrides.empty() || !dropped.empty(); }
};

/// "tolerances beyond the defaults: constraint 0.1 (default 1e-06)"; empty if there are none.
std::string loose_tolerances_line(const SolverOptions& options);

/// Those of a solution or closed loop (at least its `problem`), whose problem has been built again.
/// Throws MalformedSolution where the document lacks keys.
AnswerSettings answer_settings(const OrderedJson& document, const ProblemSpec& spec,
                               const BuiltProblem& built);

/// One line each: "setting KEY=VALUE", "dropped NAME" and loose_tolerances_line().
std::vector<std::string> settings_lines(const AnswerSettings& settings);

/// The objects of schemas/verify.schema.json: `overrides`, `dropped_constraints`,
/// `loose_tolerances`.
OrderedJson settings_json(const AnswerSettings& settings);

}  // namespace conddp
