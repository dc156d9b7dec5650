#include "systems/graphs/system_hessian.hpp"

#include <algorithm>

#include "systems/graphs/derivatives.hpp"
#include "systems/graphs/tangent_motions.hpp"

namespace conddp {
namespace {

/// Limit on nodes times columns; beyond it, second derivatives use dual numbers.
constexpr std::size_t kMostSecondDerivatives = 500000;

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

}  // namespace conddp
