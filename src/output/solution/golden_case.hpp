#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "analysis/comparison/solution_comparison.hpp"
#include "base/text/diagnostic.hpp"
#include "solvers/common/options.hpp"

namespace conddp {

/// A golden file: a problem and its known answer. It is a solution.json with only the compared
/// entries, numbers rounded to ten digits. `problem.file` is relative to its folder, and
/// `problem.overrides` are settings as for --set. `tolerances`, by their names, widen the
/// comparison for problems with less determined answers.
struct GoldenCase {
  std::string name;            ///< name of the file without suffix
  std::filesystem::path file;  ///< the golden file
  std::filesystem::path problem_file;
  std::vector<std::string> overrides;
  ComparisonTolerances tolerances;
  nlohmann::json answer;
};

/// Reads a golden file and reports its defects.
std::optional<GoldenCase> load_golden(const std::filesystem::path& file, Diagnostics& out);

/// A case without an answer yet: the future golden file of the problem in a folder.
GoldenCase new_golden(const std::filesystem::path& problem, const std::filesystem::path& folder);

/// Settings for solving a case's problem in addition to its file.
struct GoldenOptions {
  std::vector<std::string> settings;  ///< for all problems, after their own overrides
  std::function<bool()> interrupted;
};

/// Result of solving a case again.
struct GoldenOutcome {
  nlohmann::json answer;  ///< complete solution.json
  double time_s = 0;      ///< of the solve
};

/// Solves a case's problem and reports defects of the problem.
std::optional<GoldenOutcome> solve_golden(const GoldenCase& golden, const GoldenOptions& options,
                                          Diagnostics& out);

/// The text of the case's golden file with this answer.
std::string golden_text(const GoldenCase& golden, const nlohmann::json& answer);

}  // namespace conddp
