#include "systems/graphs/compiled_system.hpp"

#include <algorithm>

#include "systems/graphs/derivatives.hpp"

namespace conddp {
namespace {

/// Limit on nodes times columns; beyond it, second derivatives use dual numbers.
constexpr std::size_t kMostSecondDerivatives = 500000;

/// A system whose workspace contains the registers of its programs.
class ExpressionSystem : public SystemBase<ExpressionSystem> {
 public:
  explicit ExpressionSystem(ExpressionSystemParts parts)
      : SystemBase(parts.kind, std::move(parts.manifold),
                   static_cast<int>(parts.control_columns.size())),
        sources_(std::move(parts.sources)),
        tables_(parts.graph, parts.outputs, inputs(), parts.tables),
        functions_(parts.graph, parts.outputs, inputs(),
                   input_motions(parts.graph, manifold(), sources_)),
        hessian_([graph = std::move(parts.graph), outputs = std::move(parts.outputs),
                  sources = sources_] {
          return SystemExpressions{graph, outputs, sources};
        }) {
    state_columns_ = std::move(parts.state_columns);
    at_rest_ = std::move(parts.at_rest);
    control_columns_ = std::move(parts.control_columns);
    for (const auto& entry : functions_.jacobian()) {
      const bool of_control = entry.column >= ndx();
      const int column = of_control ? entry.column - ndx() : entry.column;
      entries_.push_back({of_control, column * rows() + entry.row, entry.place});
    }
  }

  template <class S>
  struct Data : SystemData<S> {
    explicit Data(const ExpressionSystem& system)
        : values(system.functions_.values().registers()),
          derivatives(system.functions_.with_derivatives().registers()) {
      system.functions_.values().prepare(values.data());
      system.functions_.with_derivatives().prepare(derivatives.data());
    }
    AlignedVector<S> values, derivatives;  ///< registers
  };

  template <class S>
  void evaluate_as(const S* x, const S* u, Data<S>& data) const {
    run(functions_.values(), x, u, data.values.data(), data);
  }

  template <class S>
  void differentiate_as(const S* x, const S* u, Data<S>& data) const {
    S* registers = data.derivatives.data();
    run(functions_.with_derivatives(), x, u, registers, data);
    for (const Entry& entry : entries_)
      (entry.of_control ? data.fu : data.fx)[entry.index] = registers[entry.place];
  }

  template <class S>
  void update_kinematics_as(const S*, Data<S>&) const {}

  std::vector<TableReading> table_readings(const double* x, const double* u) const override {
    return tables_.readings(
        [&](int i) { return sources_[i] < nx() ? x[sources_[i]] : u[sources_[i] - nx()]; });
  }

  std::unique_ptr<SecondDerivatives> second_derivatives(SystemData<Lane>&,
                                                        SystemData<Dual<Lane>>&) const override {
    return hessian_.derivatives(*this);
  }

 private:
  /// An entry of fx or fu that can be nonzero.
  struct Entry {
    bool of_control;
    int index;
    int place;  ///< its register
  };

  int inputs() const { return static_cast<int>(sources_.size()); }

  template <class S>
  void run(const ExpressionProgram& program, const S* x, const S* u, S* registers,
           Data<S>& data) const {
    const int n = nx();
    for (int i = 0; i < inputs(); ++i)
      registers[i] = sources_[i] < n ? x[sources_[i]] : u[sources_[i] - n];
    program.run(registers);
    for (int i = 0; i < functions_.size(); ++i) data.f[i] = registers[program.output(i)];
  }

  std::vector<int> sources_;
  TableArguments tables_;
  DifferentiableExpressions functions_;
  std::vector<Entry> entries_;  ///< all other entries are zero
  SystemHessian hessian_;
};

}  // namespace

/// Adds the whole Hessian in `finish`.
class SystemHessian::Derivatives : public SecondDerivatives {
 public:
  Derivatives(const Program& hessian, const System& system)
      : hessian_(hessian), system_(system), registers_(hessian.program.registers()) {
    hessian.program.prepare(registers_.data());
  }

  int forces() const override { return 0; }
  bool at_once() const override { return true; }
  void start(const Dual<Lane>* x, const Dual<Lane>* u) override {
    const int nx = system_.nx();
    for (std::size_t i = 0; i < hessian_.sources.size(); ++i) {
      const int source = hessian_.sources[i];
      registers_[i] = source < nx ? x[source].v : u[source - nx].v;
    }
  }
  void move_force(int) override {}
  void weigh(const Lane* of_f, const Lane*) override {
    std::copy_n(of_f, system_.rows(), registers_.begin() + hessian_.sources.size());
  }
  void move(const Dual<Lane>*, int, Lane*) override {}
  void finish(Lane* gradients) override {
    hessian_.program.run(registers_.data());
    const int nz = system_.ndx() + system_.nu();
    for (std::size_t i = 0; i < hessian_.entries.size(); ++i) {
      const auto [row, column] = hessian_.entries[i];
      const Lane value = registers_[hessian_.program.output(static_cast<int>(i))];
      gradients[column * nz + row] += value;
      if (row != column) gradients[row * nz + column] += value;
    }
  }

 private:
  const Program& hessian_;
  const System& system_;
  AlignedVector<Lane> registers_;
};

/// Builds the Hessian program of Σ wᵢ fᵢ, with the weights as additional inputs.
void SystemHessian::make(const System& system) const {
  SystemExpressions f = expressions_();
  const int inputs = static_cast<int>(f.sources.size());
  NodeId sum = f.graph.constant(0);
  for (std::size_t i = 0; i < f.outputs.size(); ++i)
    sum = f.graph.add(sum,
                      f.graph.multiply(f.graph.input(inputs + static_cast<int>(i)), f.outputs[i]));
  const InputMotions motions = input_motions(f.graph, system.manifold(), f.sources);
  const auto entries = second_derivatives(f.graph, sum, motions, kMostSecondDerivatives);
  if (!entries) return;
  Program& made = program_.emplace();
  std::vector<NodeId> values;
  for (const JacobianEntry& entry : *entries) {
    values.push_back(entry.value);
    made.entries.emplace_back(entry.row, entry.column);
  }
  made.program = ExpressionProgram(f.graph, values, inputs + system.rows(), 0);
  made.sources = std::move(f.sources);
}

std::unique_ptr<SecondDerivatives> SystemHessian::derivatives(const System& system) const {
  std::call_once(asked_, [&] { make(system); });
  return program_ ? std::make_unique<Derivatives>(*program_, system) : nullptr;
}

TableArguments::TableArguments(const ExpressionGraph& graph, std::span<const NodeId> roots,
                               int inputs, const std::vector<std::string>& names) {
  std::vector<NodeId> arguments;
  for (const NodeId id : nodes_below(graph, roots)) {
    const ExpressionNode& node = graph[id];
    if (node.operation != Operation::kTable) continue;
    const int index = TableUse::of(node.payload).table;
    const SplineTable& table = *graph.tables()[index];
    for (int i = 0; i < table.arguments(); ++i) {
      arguments.push_back(i == 0 ? node.a : node.b);
      tables_.push_back({names[index], 0, table.first(i), table.last(i)});
    }
  }
  program_ = ExpressionProgram(graph, arguments, inputs, static_cast<int>(arguments.size()));
}

std::vector<TableReading> TableArguments::readings(const std::function<double(int)>& input) const {
  std::vector<TableReading> readings = tables_;
  if (readings.empty()) return readings;
  std::vector<double> registers(program_.registers());
  program_.prepare(registers.data());
  for (int i = 0; i < program_.inputs(); ++i) registers[i] = input(i);
  program_.run(registers.data());
  for (std::size_t i = 0; i < readings.size(); ++i)
    readings[i].at = registers[program_.output(static_cast<int>(i))];
  return readings;
}

std::shared_ptr<const System> compile_system(ExpressionSystemParts parts) {
  return std::make_shared<ExpressionSystem>(std::move(parts));
}

}  // namespace conddp
