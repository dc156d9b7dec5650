#pragma once

#include <span>
#include <vector>

#include "systems/graphs/graph.hpp"

namespace conddp {

/// How an input moves along one column, the derivative as a node: 1, or on a rotation an expression
/// of the inputs.
struct InputMotion {
  int column;
  NodeId by;
};
/// The motions of each input, columns ascending; inputs behind the last one do not move.
using InputMotions = std::vector<std::vector<InputMotion>>;

/// A derivative that is not zero.
struct JacobianEntry {
  int row;
  int column;
  NodeId value;
};

/// Derivatives of outputs by columns, added to the graph; rows and then columns ascending. Forward
/// goes through the graph once with all columns that reach a node; backward once for each output,
/// and must not meet kChoose: a branch that is not taken may be singular.
std::vector<JacobianEntry> differentiate_forward(ExpressionGraph& graph,
                                                 std::span<const NodeId> outputs,
                                                 const InputMotions& motions);
std::vector<JacobianEntry> differentiate_backward(ExpressionGraph& graph,
                                                  std::span<const NodeId> outputs,
                                                  const InputMotions& motions);
/// How many derivatives differentiate_forward takes: columns that reach a node, summed over nodes.
std::size_t count_derivatives(const ExpressionGraph& graph, std::span<const NodeId> outputs,
                              const InputMotions& motions);
/// Expressions that take more derivatives than this are too large.
inline constexpr std::size_t kMostDerivatives = 1000000;
/// Whether kChoose is below the outputs.
bool has_choice(const ExpressionGraph& graph, std::span<const NodeId> outputs);

/// Second derivatives of an output by columns: entries with row ≥ column, of the symmetric part
/// where motions are not constant. Empty where nodes times columns exceed `most`.
std::optional<std::vector<JacobianEntry>> second_derivatives(ExpressionGraph& graph, NodeId output,
                                                             const InputMotions& motions,
                                                             std::size_t most);

}  // namespace conddp
