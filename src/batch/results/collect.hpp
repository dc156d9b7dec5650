#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "batch/plan/manifest.hpp"
#include "batch/results/shard_file.hpp"

namespace conddp {

/// Status of items without a result, in tables.
inline constexpr const char* kUnfinished = "unfinished";

/// Counts of the items of a run by outcome.
struct BatchStatus {
  std::size_t items = 0, solved = 0, unfinished = 0;
  std::map<std::string, std::size_t> by_status;  ///< items with a result
  double solve_s = 0;                            ///< total over all solves
};

/// Results by item id, from load_results().
using StoredResults = std::unordered_map<std::string, StoredResult>;

/// The result of an item; null if it has no result yet.
const StoredResult* find_result(const StoredResults& results, const ManifestItem& item);

/// Kinds of failures.
enum class FailureKind {
  /// All items with a result that are not solved or whose solution is damaged. Excludes loops that
  /// ended early, because they would do so again.
  kAny,
  kTimeout,  ///< time limits of solves, and killed workers
};

/// Indices of the items with this kind of failure.
std::vector<std::size_t> failed_items(const Manifest& manifest, const StoredResults& results,
                                      FailureKind kind);

BatchStatus batch_status(const Manifest& manifest, const StoredResults& results);

/// The word for successful items in tables: solved, or survived.
const char* success_word(BatchCommand command);

/// Content of results.csv: one row per item in the order of the manifest. A row contains the varied
/// values and the status. For solves it adds cost, residuals, iterations, violations by constraint
/// and the certificate's verdict; for loops the columns of the loop. The content does not depend on
/// which process solved an item, when, or how fast.
std::string results_csv(const Manifest& manifest, const StoredResults& results);

/// Content of times.csv, the figures that results.csv omits: attempts and seconds.
std::string times_csv(const Manifest& manifest, const StoredResults& results);

}  // namespace conddp
