#pragma once

#include <string>
#include <utility>
#include <vector>

#include "base/json/ordered_json.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// By what the problem of an answer differs from that of its file, and by which tolerances it was
/// judged.
struct AnswerSettings {
  std::vector<std::string> overrides;  ///< KEY=VALUE of the command line, in its order
  std::vector<std::string> dropped;    ///< names of constraints that were left out
  /// Names and values of the solver's tolerances that are larger than its defaults.
  std::vector<std::pair<std::string, double>> loose_tolerances;

  /// Whether the problem is another one than that of the file.
  bool changed() const { return !overrides.empty() || !dropped.empty(); }
};

/// Those of a solution or closed loop (at least its `problem`), whose problem has been built again.
/// Throws MalformedSolution where the document lacks keys.
AnswerSettings answer_settings(const OrderedJson& document, const ProblemSpec& spec,
                               const BuiltProblem& built);

/// One line each: "setting KEY=VALUE", "dropped NAME" and, of all tolerances, "tolerances beyond
/// the defaults: constraint 0.1 (default 1e-09)".
std::vector<std::string> settings_lines(const AnswerSettings& settings);

/// The objects of schemas/verify.schema.json: `overrides`, `dropped_constraints`,
/// `loose_tolerances`.
OrderedJson settings_json(const AnswerSettings& settings);

}  // namespace conddp
