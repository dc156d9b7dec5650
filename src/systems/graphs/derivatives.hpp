#pragma once

#include <span>
#include <vector>

#include "systems/graphs/graph.hpp"
#include "systems/graphs/program.hpp"
#include "systems/state_manifold.hpp"

namespace conddp {

/// The motion of an input along one column, as a derivative node: 1, or for a rotation an
/// expression of the inputs.
struct InputMotion {
  int column;
  NodeId by;
};
/// The motions of each input, columns ascending; inputs after the last one do not move.
using InputMotions = std::vector<std::vector<InputMotion>>;

/// A nonzero derivative.
struct JacobianEntry {
  int row;
  int column;
  NodeId value;
};

/// Derivatives of outputs by columns, added to the graph; sorted by row, then column. Forward mode
/// passes through the graph once with all columns that reach a node. Backward mode makes one pass
/// per output and does not support kChoose: a branch that is not taken may be singular.
std::vector<JacobianEntry> differentiate_forward(ExpressionGraph& graph,
                                                 std::span<const NodeId> outputs,
                                                 const InputMotions& motions);
std::vector<JacobianEntry> differentiate_backward(ExpressionGraph& graph,
                                                  std::span<const NodeId> outputs,
                                                  const InputMotions& motions);
/// The number of derivatives in differentiate_forward: columns that reach a node, summed over
/// nodes.
std::size_t count_derivatives(const ExpressionGraph& graph, std::span<const NodeId> outputs,
                              const InputMotions& motions);
/// Expressions that need more derivatives than this are too large.
inline constexpr std::size_t kMostDerivatives = 1000000;
/// True if kChoose is below the outputs.
bool has_choice(const ExpressionGraph& graph, std::span<const NodeId> outputs);

/// Second derivatives of an output by columns: entries with row ≥ column. If motions are not
/// constant, they are those of the symmetric part. Empty if nodes times columns exceed `most`.
std::optional<std::vector<JacobianEntry>> second_derivatives(ExpressionGraph& graph, NodeId output,
                                                             const InputMotions& motions,
                                                             std::size_t most);

/// Motions of the inputs that hold a state along its tangent vectors; input_of[i] is the input that
/// holds number i of the state.
InputMotions tangent_motions(ExpressionGraph& graph, const StateManifold& manifold,
                             std::span<const int> input_of);

/// Motions of the inputs along the columns of z = (tangent at x, u). Input i is number sources[i]
/// of (x, u), and each number of x is an input.
InputMotions input_motions(ExpressionGraph& graph, const StateManifold& manifold,
                           std::span<const int> sources);

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
