#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

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

}  // namespace conddp
