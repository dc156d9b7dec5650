#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/text/diagnostic.hpp"

namespace conddp {

/// Prefix of linear controls at the ends of knots in solutions. Linear controls at the nodes are
/// the last columns of the state.
inline constexpr std::string_view kEndOfKnot = "end/";

/// Prefixes of states and controls in CSV files whose name is taken by another column: the time,
/// the phase, or for a control a state.
inline constexpr std::string_view kStatePrefix = "state/";
inline constexpr std::string_view kControlPrefix = "u/";

/// Minimum difference of the increasing times of a CSV file, s: a normal number in every
/// floating-point format, and far below any step.
inline constexpr double kLeastTimeStep = 1e-30;

/// True if a column of a CSV file over time is neither a state nor a control.
bool is_time_or_phase(std::string_view column);

/// A phase of a former solution.
struct FormerPhase {
  std::string name;
  std::size_t first, last;  ///< nodes
};

/// Named columns over time.
struct DataTable {
  std::string file;
  std::vector<double> times;         ///< s, not decreasing: states jump between rows at equal times
  std::vector<std::string> columns;  ///< without the time
  /// Number of leading columns that are the state of a solution, without linear controls; absent
  /// for a CSV file.
  std::optional<std::size_t> state_columns;
  std::vector<std::vector<std::optional<double>>> rows;  ///< one row per time; cells may be empty
  std::vector<FormerPhase> phases{};                     ///< of a solution, in order; may be empty

  /// The column of this name. A name of a time or phase column also matches with a prefix.
  std::optional<std::size_t> find(const std::string& column) const;
};

/// Reads a CSV file (a header with a column `t`, or `time`; text columns are skipped) or the
/// trajectory of a solution.json. Errors are reported in the file, or at `place` if it cannot be
/// read.
std::optional<DataTable> load_data_table(const std::filesystem::path& file, const Place& place,
                                         Diagnostics& out);

/// Reads a CSV file of numbers without a required time column; a column `t` has no special meaning.
std::optional<DataTable> load_csv_columns(const std::filesystem::path& file, const Place& place,
                                          Diagnostics& out);

/// Parse the text of a CSV file or a solution.
std::optional<DataTable> parse_csv(const std::string& text, const std::string& name,
                                   Diagnostics& out);
std::optional<DataTable> parse_csv_columns(const std::string& text, const std::string& name,
                                           Diagnostics& out);
std::optional<DataTable> parse_solution(const std::string& text, const std::string& name,
                                        Diagnostics& out);

}  // namespace conddp
