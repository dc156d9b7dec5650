#pragma once

#include <span>
#include <string>
#include <string_view>

#include "solvers/common/iteration_record.hpp"

namespace conddp {

/// A column of the log, identical in solution.json and iterations.csv.
struct LogColumn {
  std::string_view name;
  std::string_view unit;  ///< empty for counts and for the cost's unit
  bool integer;
  double (*get)(const IterationRecord& row);
};

std::span<const LogColumn> log_columns();

/// The key of a column in the log of solution.json: its name and its unit.
std::string log_key(const LogColumn& column);

}  // namespace conddp
