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

/// A system's answer as expressions.
struct SystemExpressions {
  ExpressionGraph graph;
  std::vector<NodeId> outputs;  ///< System::rows
  /// Where the inputs of the graph come from: numbers of (x, u), each number of x exactly once.
  std::vector<int> sources;
};

/// The Hessian of the weighted sum of a system's answer as one program of expressions. It is made
/// when it is first asked for: many solves never need it.
class SystemHessian {
 public:
  /// `expressions` is called at most once.
  explicit SystemHessian(std::function<SystemExpressions()> expressions)
      : expressions_(std::move(expressions)) {}

  /// For the system that owns this; null where the program would be too large. Threads may call it
  /// at the same time.
  std::unique_ptr<SecondDerivatives> derivatives(const System& system) const;

 private:
  class Derivatives;
  struct Program {
    ExpressionProgram program;                 ///< its inputs are those of the graph, then weights
    std::vector<std::pair<int, int>> entries;  ///< row ≥ column of each output
    std::vector<int> sources;
  };
  void make(const System& system) const;

  std::function<SystemExpressions()> expressions_;
  mutable std::once_flag asked_;
  mutable std::optional<Program> program_;
};

}  // namespace conddp
