#pragma once

#include <vector>

#include "systems/graphs/derivatives.hpp"
#include "systems/graphs/program.hpp"

namespace conddp {

/// Expressions of some inputs, ready to be evaluated with and without their derivatives by columns
/// (tangent coordinates and controls). Immutable; S is any scalar of systems.
class DifferentiableExpressions {
 public:
  /// An entry of the Jacobian that can be other than zero.
  struct Entry {
    int row;
    int column;
    bool constant;
    double value;  ///< where it is constant
    int place;     ///< its register behind `with_derivatives`
  };

  /// The outputs are nodes of the graph, to which derivatives are added. Of forward and backward
  /// differentiation that is taken which makes fewer instructions.
  DifferentiableExpressions(ExpressionGraph& graph, const std::vector<NodeId>& outputs, int inputs,
                            const InputMotions& motions);

  int size() const { return size_; }
  const ExpressionProgram& values() const { return values_; }
  /// Its first size() outputs are the values.
  const ExpressionProgram& with_derivatives() const { return with_derivatives_; }
  /// Rows and then columns ascending.
  const std::vector<Entry>& jacobian() const { return jacobian_; }

 private:
  int size_;
  ExpressionProgram values_, with_derivatives_;
  std::vector<Entry> jacobian_;
};

}  // namespace conddp
