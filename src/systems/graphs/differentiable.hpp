#pragma once

#include <vector>

#include "systems/graphs/derivatives.hpp"
#include "systems/graphs/program.hpp"

namespace conddp {

/// Expressions compiled for evaluation with or without derivatives by columns (tangent coordinates
/// and controls). Immutable; S is any scalar of systems.
class DifferentiableExpressions {
 public:
  /// An entry of the Jacobian that can be nonzero.
  struct Entry {
    int row;
    int column;
    bool constant;
    double value;  ///< if constant
    int place;     ///< its output in `with_derivatives`
  };

  /// The outputs are nodes of the graph; their derivatives are added to it. Uses forward or
  /// backward differentiation, whichever takes fewer instructions.
  DifferentiableExpressions(ExpressionGraph& graph, const std::vector<NodeId>& outputs, int inputs,
                            const InputMotions& motions);

  int size() const { return size_; }
  const ExpressionProgram& values() const { return values_; }
  /// Its first size() outputs are the values.
  const ExpressionProgram& with_derivatives() const { return with_derivatives_; }
  /// Sorted by row, then column.
  const std::vector<Entry>& jacobian() const { return jacobian_; }

 private:
  int size_;
  ExpressionProgram values_, with_derivatives_;
  std::vector<Entry> jacobian_;
};

}  // namespace conddp
