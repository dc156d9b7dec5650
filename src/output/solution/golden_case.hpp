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

/// A golden file: a problem and what is known of its answer. It is a solution.json with the
/// compared entries alone, numbers rounded to ten digits; `problem.file` is relative to its folder,
/// and `problem.overrides` are settings as --set takes them. `tolerances`, by their names, say how
/// far apart answers may be where the problem leaves more open than others do.
struct GoldenCase {
  std::string name;            ///< the file's, without suffix
  std::filesystem::path file;  ///< the golden file
  std::filesystem::path problem_file;
  std::vector<std::string> overrides;
  ComparisonTolerances tolerances;
  nlohmann::json answer;
};

/// Reads a golden file; what is wrong with it is reported.
std::optional<GoldenCase> load_golden(const std::filesystem::path& file, Diagnostics& out);

/// A case without an answer yet: the golden file of the problem in a folder.
GoldenCase new_golden(const std::filesystem::path& problem, const std::filesystem::path& folder);

/// What a case's problem is solved with besides what its file says.
struct GoldenOptions {
  std::vector<std::string> settings;  ///< of all problems, after their own overrides
  std::function<bool()> interrupted;
};

/// A case solved again.
struct GoldenOutcome {
  nlohmann::json answer;  ///< a whole solution.json
  double time_s = 0;      ///< of the solve
};

/// Solves a case's problem; what is wrong with the problem is reported.
std::optional<GoldenOutcome> solve_golden(const GoldenCase& golden, const GoldenOptions& options,
                                          Diagnostics& out);

/// The text of the case's golden file with this answer.
std::string golden_text(const GoldenCase& golden, const nlohmann::json& answer);

}  // namespace conddp
