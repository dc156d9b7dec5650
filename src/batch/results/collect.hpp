#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "batch/plan/manifest.hpp"
#include "batch/results/shard_file.hpp"

namespace conddp {

/// The status of items that have no result, in tables.
inline constexpr const char* kUnfinished = "unfinished";

/// How many items of a run ended how.
struct BatchStatus {
  std::size_t items = 0, solved = 0, unfinished = 0;
  std::map<std::string, std::size_t> by_status;  ///< of those that have a result
  double solve_s = 0;                            ///< of all solves together
};

/// Results by the ids of items, as load_results() gives them.
using StoredResults = std::unordered_map<std::string, StoredResult>;

/// Which failures are meant.
enum class FailureKind {
  /// Everything that has a result and is not solved, or whose solution is damaged; not a loop that
  /// ended early: it would do so again.
  kAny,
  kTimeout,  ///< time limits of solves, and workers that were killed
};

/// Numbers of the items that failed so.
std::vector<std::size_t> failed_items(const Manifest& manifest, const StoredResults& results,
                                      FailureKind kind);

BatchStatus batch_status(const Manifest& manifest, const StoredResults& results);

/// What the items with success are called in tables: solved, or survived.
const char* success_word(BatchCommand command);

/// results.csv: one row an item in the order of the manifest, with what was varied, the status, and
/// cost, residuals, iterations, violations by constraint and the certificate's verdict, or how a
/// loop went. Nothing in it depends on who solved an item, when, or how fast.
std::string results_csv(const Manifest& manifest, const StoredResults& results);

/// times.csv: what results.csv leaves out: attempts and seconds.
std::string times_csv(const Manifest& manifest, const StoredResults& results);

}  // namespace conddp
