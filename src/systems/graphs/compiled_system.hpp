#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "systems/graphs/graph.hpp"
#include "systems/graphs/program.hpp"
#include "systems/system.hpp"

namespace conddp {

/// A system's output as expressions.
struct SystemExpressions {
  ExpressionGraph graph;
  std::vector<NodeId> outputs;  ///< System::rows
  /// Sources of the graph's inputs: indices into (x, u); each number of x occurs exactly once.
  std::vector<int> sources;
};

/// The Hessian of the weighted sum of a system's outputs, as a single expression program. It is
/// built on first use, because many solves do not need it.
class SystemHessian {
 public:
  /// `expressions` is called at most once.
  explicit SystemHessian(std::function<SystemExpressions()> expressions)
      : expressions_(std::move(expressions)) {}

  /// Second derivatives for the system that owns this; null if the program would be too large.
  /// Thread-safe.
  std::unique_ptr<SecondDerivatives> derivatives(const System& system) const;

 private:
  class Derivatives;
  struct Program {
    ExpressionProgram program;  ///< its inputs are those of the graph, followed by the weights
    std::vector<std::pair<int, int>> entries;  ///< (row, column) of each output, row ≥ column
    std::vector<int> sources;
  };
  void make(const System& system) const;

  std::function<SystemExpressions()> expressions_;
  mutable std::once_flag asked_;
  mutable std::optional<Program> program_;
};

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
