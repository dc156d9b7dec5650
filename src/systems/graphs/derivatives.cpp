#include "systems/graphs/derivatives.hpp"

#include <algorithm>
#include <bit>
#include <iterator>
#include <map>
#include <utility>

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

/// Fills the motions of the numbers in one segment.
class SegmentMotions {
 public:
  SegmentMotions(ExpressionGraph& graph, std::span<const int> input_of, InputMotions& motions)
      : graph_(graph), input_of_(input_of), motions_(motions) {}

  void flat(int x, int dx, int n) {
    for (int i = 0; i < n; ++i) add(x + i, dx + i, graph_.constant(1));
  }

  /// q moves by q ⊗ (δ/2, 0); its numbers x y z w start at x.
  void rotation(int x, int dx) {
    constexpr int kFactor[4][3] = {{3, 2, 1}, {2, 3, 0}, {1, 0, 3}, {0, 1, 2}};
    constexpr double kHalf[4][3] = {
        {0.5, -0.5, 0.5}, {0.5, 0.5, -0.5}, {-0.5, 0.5, 0.5}, {-0.5, -0.5, -0.5}};
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 3; ++j)
        add(x + i, dx + j,
            graph_.multiply(graph_.constant(kHalf[i][j]), number(x + kFactor[i][j])));
  }

  /// The position moves by R(q) δ; the quaternion starts at q.
  void translation(int x, int q, int dx) {
    const NodeId numbers[4] = {number(q), number(q + 1), number(q + 2), number(q + 3)};
    const auto twice = [&](int i, int j) {
      return graph_.multiply(graph_.constant(2), graph_.multiply(numbers[i], numbers[j]));
    };
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const int k = 3 - i - j;
        if (i == j) {
          const int a = (i + 1) % 3, b = (i + 2) % 3;
          add(x + i, dx + i,
              graph_.subtract(graph_.subtract(graph_.constant(1), twice(a, a)), twice(b, b)));
        } else {
          const bool positive = (i + 1) % 3 != j;
          add(x + i, dx + j,
              positive ? graph_.add(twice(i, j), twice(k, 3))
                       : graph_.subtract(twice(i, j), twice(k, 3)));
        }
      }
  }

 private:
  NodeId number(int x) { return graph_.input(input_of_[x]); }
  void add(int x, int column, NodeId by) { motions_[input_of_[x]].push_back({column, by}); }

  ExpressionGraph& graph_;
  std::span<const int> input_of_;
  InputMotions& motions_;
};

/// The derivative of an operation with one argument: `id` is its node, `a` that of the argument.
using Slope = NodeId (*)(ExpressionGraph& g, NodeId id, NodeId a);

NodeId slope_of_asin(ExpressionGraph& g, NodeId, NodeId a) {
  const NodeId rest = g.subtract(g.constant(1), g.square(a));
  return g.inverse(g.function(Operation::kSqrt, rest));
}

/// Null for operations with several arguments and for those without a derivative.
Slope slope_of(Operation operation) {
  using Graph = ExpressionGraph;
  static constexpr std::pair<Operation, Slope> kSlopes[] = {
      {Operation::kNegate, [](Graph& g, NodeId, NodeId) { return g.constant(-1); }},
      {Operation::kInverse, [](Graph& g, NodeId id, NodeId) { return g.negate(g.square(id)); }},
      {Operation::kSqrt,
       [](Graph& g, NodeId id, NodeId) { return g.multiply(g.constant(0.5), g.inverse(id)); }},
      {Operation::kSin, [](Graph& g, NodeId, NodeId a) { return g.function(Operation::kCos, a); }},
      {Operation::kCos,
       [](Graph& g, NodeId, NodeId a) { return g.negate(g.function(Operation::kSin, a)); }},
      {Operation::kTan,
       [](Graph& g, NodeId id, NodeId) { return g.add(g.constant(1), g.square(id)); }},
      {Operation::kAsin, slope_of_asin},
      {Operation::kAcos,
       [](Graph& g, NodeId id, NodeId a) { return g.negate(slope_of_asin(g, id, a)); }},
      {Operation::kAtan,
       [](Graph& g, NodeId, NodeId a) { return g.inverse(g.add(g.constant(1), g.square(a))); }},
      {Operation::kSinh,
       [](Graph& g, NodeId, NodeId a) { return g.function(Operation::kCosh, a); }},
      {Operation::kCosh,
       [](Graph& g, NodeId, NodeId a) { return g.function(Operation::kSinh, a); }},
      {Operation::kTanh,
       [](Graph& g, NodeId id, NodeId) { return g.subtract(g.constant(1), g.square(id)); }},
      {Operation::kExp, [](Graph&, NodeId id, NodeId) { return id; }},
      {Operation::kLog, [](Graph& g, NodeId, NodeId a) { return g.inverse(a); }}};
  const auto found = std::find_if(std::begin(kSlopes), std::end(kSlopes),
                                  [&](const auto& entry) { return entry.first == operation; });
  return found != std::end(kSlopes) ? found->second : nullptr;
}

template <class Visit>
void visit_atan2(ExpressionGraph& g, const ExpressionNode& node, Visit&& visit) {
  const NodeId scale = g.inverse(g.add(g.square(node.a), g.square(node.b)));
  visit(node.a, g.multiply(node.b, scale));
  visit(node.b, g.negate(g.multiply(node.a, scale)));
}

template <class Visit>
void visit_power(ExpressionGraph& g, NodeId id, const ExpressionNode& node, Visit&& visit) {
  if (!g.constant_of(node.a))
    visit(node.a, g.multiply(node.b, g.power(node.a, g.subtract(node.b, g.constant(1)))));
  if (!g.constant_of(node.b)) visit(node.b, g.multiply(id, g.function(Operation::kLog, node.a)));
}

template <class Visit>
void visit_table(ExpressionGraph& g, const ExpressionNode& node, Visit&& visit) {
  TableUse use = TableUse::of(node.payload);
  ++use.by_x;
  visit(node.a, g.table(use, node.a, node.b));
  if (node.b < 0) return;
  --use.by_x;
  ++use.by_y;
  visit(node.b, g.table(use, node.a, node.b));
}

/// Calls visit(operand, partial derivative) for the operands of a node that enter it smoothly;
/// kChoose is not visited.
template <class Visit>
void for_each_partial(ExpressionGraph& g, NodeId id, Visit&& visit) {
  const ExpressionNode node = g[id];  // the graph grows
  switch (node.operation) {
    case Operation::kAdd:
      visit(node.a, g.constant(1));
      return visit(node.b, g.constant(1));
    case Operation::kSubtract:
      visit(node.a, g.constant(1));
      return visit(node.b, g.constant(-1));
    case Operation::kMultiply:
      visit(node.a, node.b);
      return visit(node.b, node.a);
    case Operation::kAtan2:
      return visit_atan2(g, node, visit);
    case Operation::kPower:
      return visit_power(g, id, node, visit);
    case Operation::kTable:
      return visit_table(g, node, visit);
    default:
      if (const Slope slope = slope_of(node.operation)) visit(node.a, slope(g, id, node.a));
  }
}

/// Derivatives of one node, by column.
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

/// Adds the weighted motions of an input to a row.
template <class Weighted>
void add_motions(ExpressionGraph& g, const ExpressionNode& input, const InputMotions& motions,
                 Row& row, Weighted weighted) {
  if (input.payload >= static_cast<int>(motions.size())) return;
  for (const InputMotion& motion : motions[input.payload])
    add_to(g, row, motion.column, weighted(motion.by));
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
      add_motions(graph, node, motions, rows[id], [](NodeId by) { return by; });
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
  std::map<NodeId, NodeId> adjoint;  // of the nodes below the output
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
        add_motions(graph, node, motions, row,
                    [&](NodeId by) { return graph.multiply(weight, by); });
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

namespace {

/// Columns in a 64-bit word.
constexpr int kBits = 64;

/// The columns of a word along which an input moves; none for other nodes.
std::uint64_t moved_columns(const ExpressionNode& node, const InputMotions& motions, int word) {
  std::uint64_t bits = 0;
  if (node.operation != Operation::kInput || node.payload >= static_cast<int>(motions.size()))
    return bits;
  for (const InputMotion& motion : motions[node.payload])
    if (motion.column / kBits == word) bits |= std::uint64_t{1} << motion.column % kBits;
  return bits;
}

}  // namespace

std::size_t count_derivatives(const ExpressionGraph& graph, std::span<const NodeId> outputs,
                              const InputMotions& motions) {
  int columns = 0;
  for (const auto& input : motions)
    for (const InputMotion& motion : input) columns = std::max(columns, motion.column + 1);
  const std::size_t words = (columns + kBits - 1) / kBits;
  std::size_t count = 0;
  // Blocks of columns keep the memory proportional to the number of nodes.
  std::vector<std::uint64_t> reached(graph.size());
  const std::vector<NodeId> below = nodes_below(graph, outputs);
  for (std::size_t word = 0; word < words; ++word)
    for (const NodeId id : below) {
      std::uint64_t bits = moved_columns(graph[id], motions, static_cast<int>(word));
      for_each_operand(graph[id], [&](NodeId operand) { bits |= reached[operand]; });
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

namespace {

/// Entries of a symmetric matrix, by row and column.
using LowerTriangle = std::map<std::pair<int, int>, NodeId>;

void add_to(ExpressionGraph& g, LowerTriangle& sums, int first, int second, NodeId value) {
  const auto [place, is_new] =
      sums.try_emplace({std::max(first, second), std::min(first, second)}, value);
  if (!is_new) place->second = g.add(place->second, value);
}

/// True if inputs move along straight lines.
bool are_constant(const ExpressionGraph& graph, const InputMotions& motions) {
  return std::all_of(motions.begin(), motions.end(), [&](const std::vector<InputMotion>& input) {
    return std::all_of(input.begin(), input.end(),
                       [&](const InputMotion& m) { return graph.constant_of(m.by); });
  });
}

}  // namespace

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
  const bool flat = are_constant(graph, motions);
  const NodeId half = graph.constant(0.5);
  LowerTriangle sums;
  for (const JacobianEntry& entry : differentiate_forward(graph, slopes, motions)) {
    const int first = gradient[entry.row].column, second = entry.column;
    if (flat && second > first) continue;
    const bool halved = !flat && first != second;
    add_to(graph, sums, first, second, halved ? graph.multiply(half, entry.value) : entry.value);
  }
  std::vector<JacobianEntry> entries;
  for (const auto& [at, value] : sums) entries.push_back({at.first, at.second, value});
  return entries;
}

InputMotions tangent_motions(ExpressionGraph& graph, const StateManifold& manifold,
                             std::span<const int> input_of) {
  InputMotions motions(input_of.empty() ? 0
                                        : *std::max_element(input_of.begin(), input_of.end()) + 1);
  SegmentMotions segments(graph, input_of, motions);
  for (const StateManifold::Segment& segment : manifold.segments()) {
    constexpr int kPosition = 3;
    switch (segment.part) {
      case StateManifold::Part::flat:
        segments.flat(segment.x, segment.dx, segment.n);
        break;
      case StateManifold::Part::so3:
        segments.rotation(segment.x, segment.dx);
        break;
      case StateManifold::Part::se3:
        segments.translation(segment.x, segment.x + kPosition, segment.dx);
        segments.rotation(segment.x + kPosition, segment.dx + kPosition);
        break;
    }
  }
  return motions;
}

InputMotions input_motions(ExpressionGraph& graph, const StateManifold& manifold,
                           std::span<const int> sources) {
  const int nx = manifold.nx();
  std::vector<int> input_of(nx, 0);
  for (std::size_t i = 0; i < sources.size(); ++i)
    if (sources[i] < nx) input_of[sources[i]] = static_cast<int>(i);
  InputMotions motions = tangent_motions(graph, manifold, input_of);
  motions.resize(sources.size());
  for (std::size_t i = 0; i < sources.size(); ++i)
    if (sources[i] >= nx)
      motions[i].push_back({manifold.ndx() + sources[i] - nx, graph.constant(1)});
  return motions;
}

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
