#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "problem_file/assemble/build.hpp"

namespace conddp {

/// Appends a number in its shortest round-trip form, or nothing if it is not finite.
void append_cell(double value, std::string& text);

/// A text as a cell, without commas, quotes and line ends, and not starting like a formula.
std::string csv_cell(std::string text);

/// "name [unit]", or the name alone for a quantity without unit.
std::string with_unit(std::string name, std::string_view unit);

/// Columns of a trajectory in a table.
struct TableColumns {
  std::vector<int> states;  ///< indices into the state
  int first_control = 0;    ///< this and all following ones
};

/// Headers of columns, each preceded by a comma. Ambiguous names get a prefix (kStatePrefix,
/// kControlPrefix).
std::string column_headers(const BuiltProblem& built, const TableColumns& columns);

}  // namespace conddp
