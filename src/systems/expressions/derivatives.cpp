#include "systems/expressions/derivatives.hpp"

#include <algorithm>
#include <bit>
#include <map>

namespace conddp {
namespace {

/// Calls visit(operand, partial derivative) for the operands of a node on which it depends
/// smoothly; kChoose has none here.
template <class Visit>
void for_each_partial(ExpressionGraph& g, NodeId id, Visit&& visit) {
  const ExpressionNode node = g[id];  // the graph grows
  const auto one = [&] { return g.constant(1); };
  switch (node.operation) {
    case Operation::kAdd:
      visit(node.a, one());
      visit(node.b, one());
      break;
    case Operation::kSubtract:
      visit(node.a, one());
      visit(node.b, g.constant(-1));
      break;
    case Operation::kMultiply:
      visit(node.a, node.b);
      visit(node.b, node.a);
      break;
    case Operation::kNegate:
      visit(node.a, g.constant(-1));
      break;
    case Operation::kInverse:
      visit(node.a, g.negate(g.square(id)));
      break;
    case Operation::kSqrt:
      visit(node.a, g.multiply(g.constant(0.5), g.inverse(id)));
      break;
    case Operation::kSin:
      visit(node.a, g.function(Operation::kCos, node.a));
      break;
    case Operation::kCos:
      visit(node.a, g.negate(g.function(Operation::kSin, node.a)));
      break;
    case Operation::kTan:
      visit(node.a, g.add(one(), g.square(id)));
      break;
    case Operation::kAsin:
    case Operation::kAcos: {
      const NodeId rest = g.subtract(one(), g.square(node.a));
      const NodeId slope = g.inverse(g.function(Operation::kSqrt, rest));
      visit(node.a, node.operation == Operation::kAsin ? slope : g.negate(slope));
      break;
    }
    case Operation::kAtan:
      visit(node.a, g.inverse(g.add(one(), g.square(node.a))));
      break;
    case Operation::kAtan2: {
      const NodeId scale = g.inverse(g.add(g.square(node.a), g.square(node.b)));
      visit(node.a, g.multiply(node.b, scale));
      visit(node.b, g.negate(g.multiply(node.a, scale)));
      break;
    }
    case Operation::kSinh:
      visit(node.a, g.function(Operation::kCosh, node.a));
      break;
    case Operation::kCosh:
      visit(node.a, g.function(Operation::kSinh, node.a));
      break;
    case Operation::kTanh:
      visit(node.a, g.subtract(one(), g.square(id)));
      break;
    case Operation::kExp:
      visit(node.a, id);
      break;
    case Operation::kLog:
      visit(node.a, g.inverse(node.a));
      break;
    case Operation::kPower:
      if (!g.constant_of(node.a))
        visit(node.a, g.multiply(node.b, g.power(node.a, g.subtract(node.b, one()))));
      if (!g.constant_of(node.b))
        visit(node.b, g.multiply(id, g.function(Operation::kLog, node.a)));
      break;
    case Operation::kTable: {
      TableUse use = TableUse::of(node.payload);
      ++use.by_x;
      visit(node.a, g.table(use, node.a, node.b));
      if (node.b < 0) break;
      --use.by_x;
      ++use.by_y;
      visit(node.b, g.table(use, node.a, node.b));
      break;
    }
    case Operation::kConstant:
    case Operation::kInput:
    case Operation::kLess:
    case Operation::kLessEqual:
    case Operation::kChoose:
      break;
  }
}

/// Derivatives of one node by columns.
using Row = std::map<int, NodeId>;

void add_to(ExpressionGraph& g, Row& row, int column, NodeId value) {
  if (g.is_constant(value, 0)) return;
  const auto [place, is_new] = row.try_emplace(column, value);
  if (is_new) return;
  place->second = g.add(place->second, value);
  if (g.is_constant(place->second, 0)) row.erase(place);
}

Row row_of_choice(ExpressionGraph& g, NodeId condition, const Row& a, const Row& b) {
  Row row;
  const NodeId zero = g.constant(0);
  const auto at = [&](const Row& from, int column) {
    const auto place = from.find(column);
    return place == from.end() ? zero : place->second;
  };
  for (const auto& [column, value] : a)
    add_to(g, row, column, g.choose(condition, value, at(b, column)));
  for (const auto& [column, value] : b)
    if (!a.contains(column)) add_to(g, row, column, g.choose(condition, zero, value));
  return row;
}

std::vector<JacobianEntry> entries_of(int row, const Row& values) {
  std::vector<JacobianEntry> entries;
  for (const auto& [column, value] : values) entries.push_back({row, column, value});
  return entries;
}

}  // namespace

std::vector<JacobianEntry> differentiate_forward(ExpressionGraph& graph,
                                                 std::span<const NodeId> outputs,
                                                 const InputMotions& motions) {
  const std::vector<NodeId> below = nodes_below(graph, outputs);
  std::vector<Row> rows(graph.size());
  for (const NodeId id : below) {
    const ExpressionNode node = graph[id];
    if (node.operation == Operation::kInput) {
      if (node.payload < static_cast<int>(motions.size()))
        for (const InputMotion& motion : motions[node.payload])
          add_to(graph, rows[id], motion.column, motion.by);
    } else if (node.operation == Operation::kChoose) {
      rows[id] = row_of_choice(graph, node.a, rows[node.b], rows[node.c]);
    } else {
      bool moves = false;
      for_each_operand(node, [&](NodeId operand) { moves |= !rows[operand].empty(); });
      if (!moves) continue;
      for_each_partial(graph, id, [&](NodeId operand, NodeId partial) {
        for (const auto& [column, value] : rows[operand])
          add_to(graph, rows[id], column, graph.multiply(partial, value));
      });
    }
  }
  std::vector<JacobianEntry> entries;
  for (std::size_t i = 0; i < outputs.size(); ++i)
    for (const JacobianEntry& entry : entries_of(static_cast<int>(i), rows[outputs[i]]))
      entries.push_back(entry);
  return entries;
}

std::vector<JacobianEntry> differentiate_backward(ExpressionGraph& graph,
                                                  std::span<const NodeId> outputs,
                                                  const InputMotions& motions) {
  std::vector<JacobianEntry> entries;
  std::map<NodeId, NodeId> adjoint;  // of the nodes that are below the output
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    std::vector<NodeId> below = nodes_below(graph, outputs.subspan(i, 1));
    adjoint.clear();
    adjoint[outputs[i]] = graph.constant(1);
    Row row;
    for (auto id = below.rbegin(); id != below.rend(); ++id) {
      const auto found = adjoint.find(*id);
      if (found == adjoint.end()) continue;
      const NodeId weight = found->second;
      const ExpressionNode node = graph[*id];
      if (node.operation == Operation::kInput) {
        if (node.payload < static_cast<int>(motions.size()))
          for (const InputMotion& motion : motions[node.payload])
            add_to(graph, row, motion.column, graph.multiply(weight, motion.by));
        continue;
      }
      for_each_partial(graph, *id, [&](NodeId operand, NodeId partial) {
        const NodeId share = graph.multiply(partial, weight);
        const auto [place, is_new] = adjoint.try_emplace(operand, share);
        if (!is_new) place->second = graph.add(place->second, share);
      });
    }
    for (const JacobianEntry& entry : entries_of(static_cast<int>(i), row))
      entries.push_back(entry);
  }
  return entries;
}

std::size_t count_derivatives(const ExpressionGraph& graph, std::span<const NodeId> outputs,
                              const InputMotions& motions) {
  int columns = 0;
  for (const auto& input : motions)
    for (const InputMotion& motion : input) columns = std::max(columns, motion.column + 1);
  constexpr int kBits = 64;
  const std::size_t words = (columns + kBits - 1) / kBits;
  std::size_t count = 0;
  // Blocks of columns, so that the memory is that of the nodes.
  std::vector<std::uint64_t> reached(graph.size());
  const std::vector<NodeId> below = nodes_below(graph, outputs);
  for (std::size_t word = 0; word < words; ++word)
    for (const NodeId id : below) {
      const ExpressionNode& node = graph[id];
      std::uint64_t bits = 0;
      for_each_operand(node, [&](NodeId operand) { bits |= reached[operand]; });
      if (node.operation == Operation::kInput && node.payload < static_cast<int>(motions.size()))
        for (const InputMotion& motion : motions[node.payload])
          if (motion.column / kBits == static_cast<int>(word))
            bits |= std::uint64_t{1} << motion.column % kBits;
      reached[id] = bits;
      count += std::popcount(bits);
    }
  return count;
}

bool has_choice(const ExpressionGraph& graph, std::span<const NodeId> outputs) {
  const std::vector<NodeId> below = nodes_below(graph, outputs);
  return std::any_of(below.begin(), below.end(),
                     [&](NodeId id) { return graph[id].operation == Operation::kChoose; });
}

std::optional<std::vector<JacobianEntry>> second_derivatives(ExpressionGraph& graph, NodeId output,
                                                             const InputMotions& motions,
                                                             std::size_t most) {
  const std::span<const NodeId> one(&output, 1);
  const std::vector<JacobianEntry> gradient = has_choice(graph, one)
                                                  ? differentiate_forward(graph, one, motions)
                                                  : differentiate_backward(graph, one, motions);
  std::vector<NodeId> slopes;
  for (const JacobianEntry& entry : gradient) slopes.push_back(entry.value);
  if (nodes_below(graph, slopes).size() * slopes.size() > most) return std::nullopt;
  const bool flat =
      std::all_of(motions.begin(), motions.end(), [&](const std::vector<InputMotion>& input) {
        return std::all_of(input.begin(), input.end(),
                           [&](const InputMotion& m) { return graph.constant_of(m.by); });
      });
  const NodeId half = graph.constant(0.5);
  std::map<std::pair<int, int>, NodeId> sums;
  for (const JacobianEntry& entry : differentiate_forward(graph, slopes, motions)) {
    const int first = gradient[entry.row].column, second = entry.column;
    if (flat && second > first) continue;
    const bool halved = !flat && first != second;
    const NodeId share = halved ? graph.multiply(half, entry.value) : entry.value;
    const auto [place, is_new] =
        sums.try_emplace({std::max(first, second), std::min(first, second)}, share);
    if (!is_new) place->second = graph.add(place->second, share);
  }
  std::vector<JacobianEntry> entries;
  for (const auto& [at, value] : sums) entries.push_back({at.first, at.second, value});
  return entries;
}

}  // namespace conddp
