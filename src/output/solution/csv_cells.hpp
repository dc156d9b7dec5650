#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "problem_file/build/build.hpp"

namespace conddp {

/// Appends a number by shortest round trip; nothing where it is not finite.
void append_cell(double value, std::string& text);

/// A text as a cell, which holds no commas, quotes or line ends and begins no formula.
std::string csv_cell(std::string text);

/// "name [unit]", or the name alone of what has no unit.
std::string with_unit(std::string name, std::string_view unit);

/// Columns of a trajectory in a table.
struct TableColumns {
  std::vector<int> states;  ///< into the state
  int first_control = 0;    ///< and all that follow
};

/// Headers of columns, a comma before each. Names that another column has get a prefix
/// (kStatePrefix, kControlPrefix).
std::string column_headers(const BuiltProblem& built, const TableColumns& columns);

}  // namespace conddp
