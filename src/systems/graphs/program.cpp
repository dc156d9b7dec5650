#include "systems/graphs/program.hpp"

#include <algorithm>
#include <limits>
#include <unordered_map>
#include <utility>

#include "spatial/dual.hpp"
#include "systems/system.hpp"

namespace conddp {

enum class ExpressionProgram::Code : std::int32_t {
  kAdd,
  kSubtract,
  kMultiply,
  kMultiplyAdd,       ///< a b + c
  kMultiplySubtract,  ///< a b − c
  kSubtractProduct,   ///< c − a b
  kNegate,
  kInverse,
  kSqrt,
  kSinCos,  ///< sine into `to`, cosine into c
  kSin,
  kCos,
  kLess,
  kLessEqual,
  kChoose,
  // The remaining codes call libm, separately in each lane.
  kTan,
  kAsin,
  kAcos,
  kAtan,
  kAtan2,
  kSinh,
  kCosh,
  kTanh,
  kExp,
  kLog,
  kPower,
  kTable,
};

/// Orders the nodes below the outputs, fuses instructions, and gives each result a register, which
/// is reused after its last use.
class ExpressionProgram::Compiler {
 public:
  Compiler(const ExpressionGraph& graph, std::span<const NodeId> outputs, int values,
           ExpressionProgram& program)
      : graph_(graph), program_(program), place_(graph.size(), kNowhere) {
    count_uses(outputs.first(values), value_uses_);
    count_uses(outputs, uses_);
    for (NodeId id = 0; id < graph.size(); ++id)
      if (uses_[id] > 0) find_pair(id);
    for (const NodeId output : outputs) emit_with_operands(output);
    assign_registers(outputs);
  }

 private:
  static constexpr std::int32_t kNowhere = -1;

  void count_uses(std::span<const NodeId> outputs, std::vector<int>& uses) const {
    uses.assign(graph_.size(), 0);
    for (const NodeId output : outputs) ++uses[output];
    for (const NodeId id : nodes_below(graph_, outputs))
      for_each_operand(graph_[id], [&](NodeId operand) { ++uses[operand]; });
  }

  void find_pair(NodeId id) {
    const ExpressionNode& node = graph_[id];
    if (node.operation == Operation::kSin) sines_[node.a] = id;
    if (node.operation == Operation::kCos) cosines_[node.a] = id;
  }

  /// True if a product is fused into the sum that uses it. For nodes that values need, only uses by
  /// values count.
  bool fuses(NodeId product, NodeId sum) const {
    if (graph_[product].operation != Operation::kMultiply) return false;
    return (value_uses_[sum] > 0 ? value_uses_ : uses_)[product] == 1;
  }

  /// The code of an operation that maps to a single instruction.
  static Code code_of(Operation operation) {
    static constexpr std::pair<Operation, Code> kCodes[] = {
        {Operation::kAdd, Code::kAdd},
        {Operation::kSubtract, Code::kSubtract},
        {Operation::kMultiply, Code::kMultiply},
        {Operation::kNegate, Code::kNegate},
        {Operation::kInverse, Code::kInverse},
        {Operation::kSqrt, Code::kSqrt},
        {Operation::kSin, Code::kSin},
        {Operation::kCos, Code::kCos},
        {Operation::kTan, Code::kTan},
        {Operation::kAsin, Code::kAsin},
        {Operation::kAcos, Code::kAcos},
        {Operation::kAtan, Code::kAtan},
        {Operation::kAtan2, Code::kAtan2},
        {Operation::kSinh, Code::kSinh},
        {Operation::kCosh, Code::kCosh},
        {Operation::kTanh, Code::kTanh},
        {Operation::kExp, Code::kExp},
        {Operation::kLog, Code::kLog},
        {Operation::kPower, Code::kPower},
        {Operation::kLess, Code::kLess},
        {Operation::kLessEqual, Code::kLessEqual},
        {Operation::kChoose, Code::kChoose}};
    return std::find_if(std::begin(kCodes), std::end(kCodes),
                        [&](const auto& entry) { return entry.first == operation; })
        ->second;
  }

  /// The instruction of an inner node, with nodes in place of registers.
  Instruction instruction_of(NodeId id) const {
    const ExpressionNode& node = graph_[id];
    switch (node.operation) {
      case Operation::kAdd:
      case Operation::kSubtract:
        return sum_of(id);
      case Operation::kSin:
      case Operation::kCos:
        if (const auto sine = sines_.find(node.a), cosine = cosines_.find(node.a);
            sine != sines_.end() && cosine != cosines_.end())
          return {Code::kSinCos, sine->second, node.a, kNowhere, cosine->second};
        return plain(id);
      case Operation::kTable:
        // A single argument serves as both operands, so that both have a register.
        return {Code::kTable, id, node.a, node.b < 0 ? node.a : node.b, node.payload};
      default:
        return plain(id);
    }
  }

  Instruction plain(NodeId id) const {
    const ExpressionNode& node = graph_[id];
    return {code_of(node.operation), id, node.a, node.b, node.c};
  }

  /// A sum or difference, fused with a product if possible.
  Instruction sum_of(NodeId id) const {
    const ExpressionNode& node = graph_[id];
    const bool adds = node.operation == Operation::kAdd;
    const auto fused = [&](Code code, NodeId product, NodeId other) {
      return Instruction{code, id, graph_[product].a, graph_[product].b, other};
    };
    if (fuses(node.a, id))
      return fused(adds ? Code::kMultiplyAdd : Code::kMultiplySubtract, node.a, node.b);
    if (fuses(node.b, id))
      return fused(adds ? Code::kMultiplyAdd : Code::kSubtractProduct, node.b, node.a);
    return plain(id);
  }

  /// Calls visit(node) for each operand of an instruction.
  template <class Visit>
  static void for_each_read(const Instruction& i, Visit&& visit) {
    visit(i.a);
    if (i.b >= 0) visit(i.b);
    if (i.c >= 0 && i.code != Code::kSinCos && i.code != Code::kTable) visit(i.c);
  }

  bool is_emitted(NodeId id) const { return place_[id] != kNowhere; }
  bool is_leaf(NodeId id) const {
    return graph_[id].operation == Operation::kConstant ||
           graph_[id].operation == Operation::kInput;
  }

  void emit_with_operands(NodeId root) {
    std::vector<NodeId> open{root};
    while (!open.empty()) {
      const NodeId id = open.back();
      if (is_emitted(id) || is_leaf(id)) {
        open.pop_back();
        continue;
      }
      const Instruction instruction = instruction_of(id);
      const std::size_t before = open.size();
      for_each_read(instruction, [&](NodeId operand) {
        if (!is_emitted(operand) && !is_leaf(operand)) open.push_back(operand);
      });
      if (open.size() > before) continue;
      open.pop_back();
      place_[instruction.to] = static_cast<std::int32_t>(program_.instructions_.size());
      if (instruction.code == Code::kSinCos) place_[instruction.c] = place_[instruction.to];
      program_.instructions_.push_back(instruction);
    }
  }

  void assign_registers(std::span<const NodeId> outputs) {
    std::vector<Instruction>& code = program_.instructions_;
    std::vector<int> last_use = last_uses(outputs);
    place_leaves(outputs);
    for (std::size_t i = 0; i < code.size(); ++i) {
      Instruction& instruction = code[i];
      const Instruction of_nodes = instruction;
      instruction.a = registered(instruction.a);
      instruction.b = registered(instruction.b);
      if (instruction.code != Code::kSinCos && instruction.code != Code::kTable)
        instruction.c = registered(instruction.c);
      for_each_read(of_nodes, [&](NodeId id) {
        if (is_leaf(id) || last_use[id] != static_cast<int>(i)) return;
        free_.push_back(registers_[id]);
        last_use[id] = -1;  // an operand that is read twice is released once
      });
      instruction.to = take_register(of_nodes.to);
      if (instruction.code == Code::kSinCos) instruction.c = take_register(of_nodes.c);
    }
    for (const NodeId output : outputs) program_.outputs_.push_back(registers_[output]);
  }

  /// For each node, the last instruction that reads it; outputs stay alive until the end.
  std::vector<int> last_uses(std::span<const NodeId> outputs) const {
    constexpr int kAlways = std::numeric_limits<int>::max();
    std::vector<int> last_use(graph_.size(), 0);
    const std::vector<Instruction>& code = program_.instructions_;
    for (std::size_t i = 0; i < code.size(); ++i)
      for_each_read(code[i], [&](NodeId id) { last_use[id] = static_cast<int>(i); });
    for (const NodeId output : outputs) last_use[output] = kAlways;
    return last_use;
  }

  /// Inputs come first, then constants.
  void place_leaves(std::span<const NodeId> outputs) {
    registers_.assign(graph_.size(), kNowhere);
    program_.registers_ = program_.inputs_;
    for (const Instruction& i : program_.instructions_)
      for_each_read(i, [&](NodeId id) { place_leaf(id); });
    for (const NodeId output : outputs) place_leaf(output);
  }

  void place_leaf(NodeId id) {
    const ExpressionNode& node = graph_[id];
    if (registers_[id] != kNowhere) return;
    if (node.operation == Operation::kInput) registers_[id] = node.payload;
    if (node.operation == Operation::kConstant) {
      registers_[id] = program_.registers_++;
      program_.constants_.push_back(node.constant);
    }
  }

  std::int32_t registered(std::int32_t id) const { return id < 0 ? id : registers_[id]; }

  std::int32_t take_register(NodeId id) {
    if (free_.empty()) free_.push_back(program_.registers_++);
    registers_[id] = free_.back();
    free_.pop_back();
    return registers_[id];
  }

  const ExpressionGraph& graph_;
  ExpressionProgram& program_;
  std::vector<int> value_uses_, uses_;
  std::unordered_map<NodeId, NodeId> sines_, cosines_;  ///< by argument
  std::vector<std::int32_t> place_;                     ///< index among the instructions
  std::vector<std::int32_t> registers_;                 ///< by node
  std::vector<std::int32_t> free_;                      ///< registers that are no longer in use
};

ExpressionProgram::ExpressionProgram(const ExpressionGraph& graph, std::span<const NodeId> outputs,
                                     int inputs, int values)
    : inputs_(inputs), tables_(graph.tables()) {
  Compiler(graph, outputs, values, *this);
}

template <class S>
void ExpressionProgram::prepare(S* registers) const {
  for (std::size_t i = 0; i < constants_.size(); ++i) registers[inputs_ + i] = S(constants_[i]);
}

/// Not inlined, to keep its register pressure away from the arithmetic.
template <class S>
[[gnu::noinline]] void ExpressionProgram::run_function(const Instruction& i, S* r) const {
  const S a = r[i.a];
  S& to = r[i.to];
  switch (i.code) {
    case Code::kTan:
      to = tan(a);
      break;
    case Code::kAsin:
      to = asin(a);
      break;
    case Code::kAcos:
      to = acos(a);
      break;
    case Code::kAtan:
      to = atan(a);
      break;
    case Code::kAtan2:
      to = atan2(a, r[i.b]);
      break;
    case Code::kSinh:
      to = sinh(a);
      break;
    case Code::kCosh:
      to = cosh(a);
      break;
    case Code::kTanh:
      to = tanh(a);
      break;
    case Code::kExp:
      to = exp(a);
      break;
    case Code::kLog:
      to = log(a);
      break;
    case Code::kPower:
      to = pow(a, r[i.b]);
      break;
    case Code::kTable: {
      const TableUse use = TableUse::of(i.c);
      to = table_value(*tables_[use.table], use.by_x, use.by_y, a, r[i.b]);
      break;
    }
    default:
      break;
  }
}

template <class S>
void ExpressionProgram::run(S* r) const {
  for (const Instruction& i : instructions_) {
    switch (i.code) {
      case Code::kAdd:
        r[i.to] = r[i.a] + r[i.b];
        break;
      case Code::kSubtract:
        r[i.to] = r[i.a] - r[i.b];
        break;
      case Code::kMultiply:
        r[i.to] = r[i.a] * r[i.b];
        break;
      case Code::kMultiplyAdd:
        r[i.to] = r[i.a] * r[i.b] + r[i.c];
        break;
      case Code::kMultiplySubtract:
        r[i.to] = r[i.a] * r[i.b] - r[i.c];
        break;
      case Code::kSubtractProduct:
        r[i.to] = r[i.c] - r[i.a] * r[i.b];
        break;
      case Code::kNegate:
        r[i.to] = -r[i.a];
        break;
      case Code::kInverse:
        r[i.to] = S(1.0) / r[i.a];
        break;
      case Code::kSqrt:
        r[i.to] = sqrt(r[i.a]);
        break;
      case Code::kSinCos: {
        S s, c;
        sincos(r[i.a], s, c);
        r[i.to] = s;
        r[i.c] = c;
        break;
      }
      case Code::kSin:
        r[i.to] = sin(r[i.a]);
        break;
      case Code::kCos:
        r[i.to] = cos(r[i.a]);
        break;
      case Code::kLess:
        r[i.to] = select(r[i.a] < r[i.b], S(1.0), S(0.0));
        break;
      case Code::kLessEqual:
        r[i.to] = select(r[i.a] <= r[i.b], S(1.0), S(0.0));
        break;
      case Code::kChoose:
        r[i.to] = select(r[i.a] > S(0.5), r[i.b], r[i.c]);
        break;
      default:
        run_function(i, r);
    }
  }
}

#define CONDDP_INSTANTIATE(S)                                   \
  template void ExpressionProgram::prepare(S* registers) const; \
  template void ExpressionProgram::run(S* registers) const;
CONDDP_FOR_EACH_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
