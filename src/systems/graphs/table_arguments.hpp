#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "systems/graphs/program.hpp"
#include "systems/table_reading.hpp"

namespace conddp {

/// The arguments with which the expressions of a graph read its tables. Immutable.
class TableArguments {
 public:
  TableArguments() = default;
  /// Of the tables below the roots. `names`: of the tables of the graph, in its order; `inputs`: of
  /// the graph.
  TableArguments(const ExpressionGraph& graph, std::span<const NodeId> roots, int inputs,
                 const std::vector<std::string>& names);

  /// `input`: the value of each input of the graph.
  std::vector<TableReading> readings(const std::function<double(int)>& input) const;

 private:
  std::vector<TableReading> tables_;  ///< an entry for each argument, without where it is
  ExpressionProgram program_;         ///< of the arguments
};

}  // namespace conddp
