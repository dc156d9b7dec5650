#include "systems/graphs/differentiable.hpp"

namespace conddp {
namespace {

ExpressionProgram program_with(const ExpressionGraph& graph, std::vector<NodeId> outputs,
                               const std::vector<JacobianEntry>& entries, int inputs) {
  const int values = static_cast<int>(outputs.size());
  for (const JacobianEntry& entry : entries) outputs.push_back(entry.value);
  return {graph, outputs, inputs, values};
}

/// Number of nodes that backward differentiation visits.
std::size_t backward_work(const ExpressionGraph& graph, const std::vector<NodeId>& outputs) {
  std::size_t work = 0;
  for (const NodeId& output : outputs) work += nodes_below(graph, {&output, 1}).size();
  return work;
}

}  // namespace

DifferentiableExpressions::DifferentiableExpressions(ExpressionGraph& graph,
                                                     const std::vector<NodeId>& outputs, int inputs,
                                                     const InputMotions& motions)
    : size_(static_cast<int>(outputs.size())), values_(graph, outputs, inputs, size_) {
  std::vector<JacobianEntry> entries = differentiate_forward(graph, outputs, motions);
  with_derivatives_ = program_with(graph, outputs, entries, inputs);
  if (!has_choice(graph, outputs) && backward_work(graph, outputs) <= kMostDerivatives) {
    std::vector<JacobianEntry> backward = differentiate_backward(graph, outputs, motions);
    ExpressionProgram other = program_with(graph, outputs, backward, inputs);
    if (other.instructions() < with_derivatives_.instructions()) {
      entries = std::move(backward);
      with_derivatives_ = std::move(other);
    }
  }
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const auto constant = graph.constant_of(entries[i].value);
    jacobian_.push_back({entries[i].row, entries[i].column, constant.has_value(),
                         constant.value_or(0),
                         with_derivatives_.output(size_ + static_cast<int>(i))});
  }
}

}  // namespace conddp
