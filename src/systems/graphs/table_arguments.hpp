#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "systems/graphs/program.hpp"
#include "systems/table_reading.hpp"

namespace conddp {

/// The arguments of the table readings in the expressions of a graph. Immutable.
class TableArguments {
 public:
  TableArguments() = default;
  /// Covers the tables below the roots. `names` lists the graph's tables in order; `inputs` is the
  /// number of the graph's inputs.
  TableArguments(const ExpressionGraph& graph, std::span<const NodeId> roots, int inputs,
                 const std::vector<std::string>& names);

  /// `input`: the value of each input of the graph.
  std::vector<TableReading> readings(const std::function<double(int)>& input) const;

 private:
  std::vector<TableReading> tables_;  ///< an entry for each argument, with the position unset
  ExpressionProgram program_;         ///< computes the arguments
};

}  // namespace conddp
