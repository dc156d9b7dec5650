#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/text/diagnostic.hpp"

namespace conddp {

/// What stands before the names of linear controls in solutions where they are those at the ends of
/// knots. Those at the nodes are the last columns of the state.
inline constexpr std::string_view kEndOfKnot = "end/";

/// What stands before the names of states and controls in CSV files where the name is that of
/// another column: the time's, the phase's, or, of a control, a state's.
inline constexpr std::string_view kStatePrefix = "state/";
inline constexpr std::string_view kControlPrefix = "u/";

/// Times of a CSV file, which have to increase, differ by at least this, s: a normal number in
/// every floating-point format, and far below any step.
inline constexpr double kLeastTimeStep = 1e-30;

/// Whether a column of this name in a CSV file over time is not a state or a control.
bool is_time_or_phase(std::string_view column);

/// A phase of a former solution.
struct FormerPhase {
  std::string name;
  std::size_t first, last;  ///< of its nodes
};

/// Named columns over time.
struct DataTable {
  std::string file;
  std::vector<double> times;         ///< s, not decreasing: states jump between rows at one time
  std::vector<std::string> columns;  ///< without the time
  /// How many of them, from the first, are the state of a solution, linear controls not among them;
  /// absent: a CSV file.
  std::optional<std::size_t> state_columns;
  std::vector<std::vector<std::optional<double>>> rows;  ///< one a time; empty cells are allowed
  std::vector<FormerPhase> phases{};                     ///< of a solution that has them, in order

  /// The column of this name; of a time's or phase's name also one with a prefix.
  std::optional<std::size_t> find(const std::string& column) const;
};

/// Reads a CSV file (a header with a column `t`, or `time`; text columns are skipped) or the
/// trajectory of a solution.json. What is wrong is reported in the file, or at `place` where the
/// file cannot be read at all.
std::optional<DataTable> load_data_table(const std::filesystem::path& file, const Place& place,
                                         Diagnostics& out);

/// Reads a CSV file whose columns are numbers and need not have the time among them; one called `t`
/// is a column like the others.
std::optional<DataTable> load_csv_columns(const std::filesystem::path& file, const Place& place,
                                          Diagnostics& out);

/// The same for one of the two, from its text.
std::optional<DataTable> parse_csv(const std::string& text, const std::string& name,
                                   Diagnostics& out);
std::optional<DataTable> parse_csv_columns(const std::string& text, const std::string& name,
                                           Diagnostics& out);
std::optional<DataTable> parse_solution(const std::string& text, const std::string& name,
                                        Diagnostics& out);

}  // namespace conddp
