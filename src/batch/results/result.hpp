#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/json/ordered_json.hpp"

namespace conddp {

/// Ends of items that no solver reports.
inline constexpr std::string_view kCrashed = "crashed";            ///< the worker died
inline constexpr std::string_view kKilled = "killed";              ///< it did not end in time
inline constexpr std::string_view kOutOfMemory = "out_of_memory";  ///< limits.max_memory_mb
inline constexpr std::string_view kUnsolvable = "not_built";       ///< its files have changed
inline constexpr std::string_view kDefect = "defect";              ///< an error of conddp itself

/// How one item ended. A row of results.
struct ItemResult {
  std::string id;
  std::string status;    ///< of the solve, the end of the loop, or one of those above
  bool success = false;  ///< it is solved and its certificate holds, or the loop lasted
  int attempt = 1;
  /// Where the whole solution is in the pack of the shard; 0 bytes: it is not kept.
  std::size_t solution_offset = 0, solution_bytes = 0;
  std::uint64_t solution_sum = 0;  ///< check_sum() of these bytes
  /// What does not depend on the run: solver, message, cost, iterations, residuals, constraints,
  /// certificate; of a loop kLoopColumns; empty where nothing was solved.
  OrderedJson answer;
  OrderedJson times;  ///< s

  /// Of two results of one item, whether this one counts.
  bool counts_before(const ItemResult& other) const {
    return success != other.success ? success : attempt > other.attempt;
  }
};

/// The result on one line, without its end.
std::string result_line(const ItemResult& result);
/// Throws OrderedJson::exception where the line is no result.
ItemResult parse_result(std::string_view line);

}  // namespace conddp
