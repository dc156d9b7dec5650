#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/json/ordered_json.hpp"

namespace conddp {

/// Item outcomes other than a solver's status.
inline constexpr std::string_view kCrashed = "crashed";            ///< the worker died
inline constexpr std::string_view kKilled = "killed";              ///< it exceeded its time
inline constexpr std::string_view kOutOfMemory = "out_of_memory";  ///< limits.max_memory_mb
inline constexpr std::string_view kUnsolvable = "not_built";       ///< its files have changed
inline constexpr std::string_view kDefect = "defect";              ///< an error of conddp itself

/// The outcome of one item; a row of results.
struct ItemResult {
  std::string id;
  std::string status;    ///< status of the solve, end of the loop, or one of the outcomes above
  bool success = false;  ///< solved with a passing certificate, or a loop that lasted
  int attempt = 1;
  /// Location of the solution in the shard's pack; 0 bytes if it is not stored.
  std::size_t solution_offset = 0, solution_bytes = 0;
  std::uint64_t solution_sum = 0;  ///< check_sum() of these bytes
  /// Figures that do not depend on the run: solver, message, cost, iterations, residuals,
  /// constraints, certificate; for a loop, kLoopColumns. Empty if no solve took place.
  OrderedJson answer;
  OrderedJson times;  ///< s

  /// True if this result takes precedence over another one of the same item.
  bool counts_before(const ItemResult& other) const {
    return success != other.success ? success : attempt > other.attempt;
  }
};

/// The result as a single line, without its line end.
std::string result_line(const ItemResult& result);
/// Throws OrderedJson::exception if the line is not a result.
ItemResult parse_result(std::string_view line);

}  // namespace conddp
