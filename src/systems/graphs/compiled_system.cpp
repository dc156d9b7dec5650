#include "systems/graphs/compiled_system.hpp"

#include <algorithm>

#include "systems/graphs/differentiable.hpp"
#include "systems/graphs/system_hessian.hpp"
#include "systems/graphs/table_arguments.hpp"
#include "systems/graphs/tangent_motions.hpp"

namespace conddp {
namespace {

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

std::shared_ptr<const System> compile_system(ExpressionSystemParts parts) {
  return std::make_shared<ExpressionSystem>(std::move(parts));
}

}  // namespace conddp
