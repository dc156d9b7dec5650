#pragma once

#include <span>
#include <vector>

#include "systems/graphs/graph.hpp"

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

}  // namespace conddp
