#pragma once

#include <memory>
#include <vector>

#include "systems/graphs/graph.hpp"
#include "systems/system.hpp"

namespace conddp {

/// The parts of a system of expressions.
struct ExpressionSystemParts {
  SystemKind kind = SystemKind::first_order;
  StateManifold manifold;
  std::vector<Column> state_columns, control_columns;
  std::vector<bool> at_rest;  ///< by column of the state; empty if no column is at rest
  ExpressionGraph graph;
  std::vector<std::string> tables;  ///< names of the graph's tables
  std::vector<NodeId> outputs;      ///< the rows of the system
  /// Sources of the graph's inputs: indices into (x, u); each number of x occurs exactly once.
  std::vector<int> sources;
};

/// The system whose result is the outputs.
std::shared_ptr<const System> compile_system(ExpressionSystemParts parts);

}  // namespace conddp
