#include "systems/expressions/compiled_system.hpp"

#include <algorithm>

#include "systems/expressions/differentiable.hpp"
#include "systems/expressions/tangent_motions.hpp"

namespace conddp {
namespace {

/// Second derivatives of a system by parts are left to dual numbers where they would take more
/// nodes times columns than this.
constexpr std::size_t kMostSecondDerivatives = 500000;

/// Registers of its programs are the system's data.
class ExpressionSystem : public SystemBase<ExpressionSystem> {
 public:
  explicit ExpressionSystem(ExpressionSystemParts parts)
      : SystemBase(parts.kind, std::move(parts.manifold),
                   static_cast<int>(parts.control_columns.size())),
        sources_(std::move(parts.sources)),
        motions_(input_motions(parts.graph)),
        functions_(parts.graph, parts.outputs, inputs(), motions_) {
    state_columns_ = std::move(parts.state_columns);
    control_columns_ = std::move(parts.control_columns);
    for (const auto& entry : functions_.jacobian()) {
      const bool of_control = entry.column >= ndx();
      const int column = of_control ? entry.column - ndx() : entry.column;
      entries_.push_back({of_control, column * rows() + entry.row, entry.place});
    }
    if (kind_ == SystemKind::second_order) make_second_derivatives(parts);
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

  std::unique_ptr<SecondDerivatives> second_derivatives(
      SystemData<Lane>& at, SystemData<Dual<Lane>>& moving) const override;

 private:
  /// An entry of fx or fu that can be other than zero.
  struct Entry {
    bool of_control;
    int index;
    int place;  ///< its register
  };
  class Curvature;

  int inputs() const { return static_cast<int>(sources_.size()); }

  InputMotions input_motions(ExpressionGraph& graph) const {
    std::vector<int> input_of(nx(), 0);
    for (int i = 0; i < inputs(); ++i)
      if (sources_[i] < nx()) input_of[sources_[i]] = i;
    InputMotions motions = tangent_motions(graph, manifold(), input_of);
    motions.resize(inputs());
    for (int i = 0; i < inputs(); ++i)
      if (sources_[i] >= nx())
        motions[i].push_back({ndx() + sources_[i] - nx(), graph.constant(1)});
    return motions;
  }

  /// Of Σ wᵢ fᵢ, with the weights as further inputs.
  void make_second_derivatives(ExpressionSystemParts& parts) {
    ExpressionGraph& graph = parts.graph;
    NodeId sum = graph.constant(0);
    for (int i = 0; i < rows(); ++i)
      sum = graph.add(sum, graph.multiply(graph.input(inputs() + i), parts.outputs[i]));
    const auto entries = conddp::second_derivatives(graph, sum, motions_, kMostSecondDerivatives);
    if (!entries) return;
    has_second_derivatives_ = true;
    std::vector<NodeId> outputs;
    for (const JacobianEntry& entry : *entries) {
      outputs.push_back(entry.value);
      hessian_pattern_.emplace_back(entry.row, entry.column);
    }
    hessian_ = ExpressionProgram(graph, outputs, inputs() + rows(), 0);
  }

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
  InputMotions motions_;
  DifferentiableExpressions functions_;
  std::vector<Entry> entries_;  ///< all others stay zero
  bool has_second_derivatives_ = false;
  ExpressionProgram hessian_;
  std::vector<std::pair<int, int>> hessian_pattern_;
};

/// The Hessian of the weighted accelerations, all of it at once.
class ExpressionSystem::Curvature : public SecondDerivatives {
 public:
  Curvature(const ExpressionSystem& system, const Data<Lane>& at)
      : system_(system), at_(at), registers_(system.hessian_.registers()) {
    system.hessian_.prepare(registers_.data());
  }

  int forces() const override { return 0; }
  void start(const Dual<Lane>*) override {
    std::copy_n(at_.derivatives.begin(), system_.inputs(), registers_.begin());
  }
  void move_force(int) override {}
  void weigh(const Lane* of_f, const Lane*) override {
    std::copy_n(of_f, system_.rows(), registers_.begin() + system_.inputs());
  }
  void move(const Dual<Lane>*, int, Lane*) override {}
  void finish(Lane* gradients) override {
    system_.hessian_.run(registers_.data());
    const int n = system_.ndx() + system_.nu();
    for (std::size_t i = 0; i < system_.hessian_pattern_.size(); ++i) {
      const auto [row, column] = system_.hessian_pattern_[i];
      const Lane value = registers_[system_.hessian_.output(static_cast<int>(i))];
      gradients[column * n + row] += value;
      if (row != column) gradients[row * n + column] += value;
    }
  }

 private:
  const ExpressionSystem& system_;
  const Data<Lane>& at_;
  AlignedVector<Lane> registers_;
};

std::unique_ptr<SecondDerivatives> ExpressionSystem::second_derivatives(
    SystemData<Lane>& at, SystemData<Dual<Lane>>& /*moving*/) const {
  if (!has_second_derivatives_) return nullptr;
  return std::make_unique<Curvature>(*this, static_cast<Data<Lane>&>(at));
}

}  // namespace

std::shared_ptr<const System> compile_system(ExpressionSystemParts parts) {
  return std::make_shared<ExpressionSystem>(std::move(parts));
}

}  // namespace conddp
