#pragma once

#include <memory>
#include <vector>

#include "systems/graphs/graph.hpp"
#include "systems/system.hpp"

namespace conddp {

/// What a system of expressions is made of.
struct ExpressionSystemParts {
  SystemKind kind = SystemKind::first_order;
  StateManifold manifold;
  std::vector<Column> state_columns, control_columns;
  std::vector<bool> at_rest;  ///< by column of the state; empty: none is
  ExpressionGraph graph;
  std::vector<std::string> tables;  ///< the names of the graph's
  std::vector<NodeId> outputs;      ///< the rows of the system
  /// Where the inputs of the graph come from: numbers of (x, u), each number of x exactly once.
  std::vector<int> sources;
};

/// The system whose answer the outputs are.
std::shared_ptr<const System> compile_system(ExpressionSystemParts parts);

}  // namespace conddp
