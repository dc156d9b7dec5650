#include "systems/expressions/system.hpp"

#include <algorithm>
#include <span>

#include <fmt/format.h>

#include "base/spelling.hpp"
#include "base/utf8.hpp"
#include "systems/expressions/differentiable.hpp"
#include "systems/expressions/tangent_motions.hpp"

namespace conddp {
namespace {

/// Second derivatives of a system by parts are left to dual numbers where they would take more
/// nodes times columns than this.
constexpr std::size_t kMostSecondDerivatives = 500000;

/// What a system of expressions is made of.
struct SystemParts {
  SystemKind kind;
  StateManifold manifold;
  std::vector<Column> state_columns, control_columns;
  ExpressionGraph graph;
  std::vector<NodeId> outputs;
  /// Where the inputs of the graph come from: numbers of (x, u).
  std::vector<int> sources;
};

class ExpressionSystem : public SystemBase<ExpressionSystem> {
 public:
  explicit ExpressionSystem(SystemParts parts)
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
      entries_.push_back(
          {of_control, column * rows() + entry.row, entry.place, entry.constant, entry.value});
    }
    std::stable_partition(entries_.begin(), entries_.end(),
                          [](const Entry& entry) { return !entry.constant; });
    changing_ = static_cast<int>(std::count_if(entries_.begin(), entries_.end(),
                                               [](const Entry& entry) { return !entry.constant; }));
    if (kind_ == SystemKind::second_order) make_second_derivatives(parts);
  }

  template <class S>
  struct Data : SystemData<S> {
    explicit Data(const ExpressionSystem& system)
        : values(system.functions_.values().registers()),
          derivatives(system.functions_.with_derivatives().registers()) {
      system.functions_.values().prepare(values.data());
      system.functions_.with_derivatives().prepare(derivatives.data());
      this->fx.assign(system.rows() * system.ndx(), S(0.0));
      this->fu.assign(system.rows() * system.nu(), S(0.0));
      for (std::size_t i = system.changing_; i < system.entries_.size(); ++i)
        system.entries_[i].in(*this) = S(system.entries_[i].value);
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
    for (int i = 0; i < changing_; ++i) entries_[i].in(data) = registers[entries_[i].place];
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
    bool constant;
    double value;  ///< where it is constant

    template <class S>
    S& in(SystemData<S>& data) const {
      return (of_control ? data.fu : data.fx)[index];
    }
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
  void make_second_derivatives(SystemParts& parts) {
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
  std::vector<Entry> entries_;  ///< constant ones last
  int changing_ = 0;
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

/// Reads the texts of a system.
class SystemReader {
 public:
  using Part = ExpressionSystemMessage::Part;

  SystemReader(const ExpressionSystemText& text, ParsedExpressionSystem& out)
      : text_(text), out_(out) {
    parts_.kind = text.kind;
  }

  void read() {
    if (text_.states.empty()) return report(Part::kWhole, 0, "the system has no states");
    if (second_order() && text_.velocities.size() != text_.states.size())
      return report(Part::kWhole, 0,
                    fmt::format("there are {} positions and {} velocities", text_.states.size(),
                                text_.velocities.size()));
    // Later texts would stumble over what is wrong with the names before them.
    parts_.state_columns = add_names();
    if (out_.errors.empty()) read_definitions();
    if (out_.errors.empty()) read_equations();
    if (!out_.errors.empty()) return;
    if (clock_ >= 0) add_clock();
    if (is_too_large())
      return report(Part::kWhole, 0, "the expressions of the system are too large");
    out_.usual_state = parts_.manifold.neutral();
    if (clock_ >= 0 && second_order()) out_.usual_state.back() = 1;
    out_.system = std::make_shared<ExpressionSystem>(std::move(parts_));
  }

 private:
  bool second_order() const { return text_.kind == SystemKind::second_order; }

  bool is_too_large() {
    InputMotions motions;  // of everything by itself, as of a flat state
    for (std::size_t i = 0; i < parts_.sources.size(); ++i)
      motions.push_back({{static_cast<int>(i), parts_.graph.constant(1)}});
    return count_derivatives(parts_.graph, parts_.outputs, motions) > kMostDerivatives;
  }

  void report(Part part, int index, std::string message, std::string hint = {}) {
    out_.errors.push_back({part, index, false, {0, std::move(message), std::move(hint)}});
  }

  /// Whether the name is good and new.
  bool check_name(Part part, int index, const std::string& name) {
    std::string defect = name == "t" && text_.kind != SystemKind::discrete ? "'t' is the time"
                                                                           : scope_.defect_of(name);
    if (defect.empty()) return true;
    report(part, index, std::move(defect));
    return false;
  }

  /// The next inputs, as a value.
  ExpressionValue inputs(int count) {
    std::vector<NodeId> nodes;
    for (int i = 0; i < count; ++i) {
      nodes.push_back(parts_.graph.input(static_cast<int>(parts_.sources.size())));
      parts_.sources.push_back(static_cast<int>(parts_.sources.size()));
    }
    return count == 1 ? ExpressionValue::number(nodes[0]) : ExpressionValue::vector(nodes);
  }

  /// Names of states, velocities, controls, the clock, parameters and tables; returns the columns
  /// of the state.
  std::vector<Column> add_names() {
    std::vector<Column> columns;
    int velocities = 0;
    for (std::size_t i = 0; i < text_.states.size(); ++i)
      velocities += add_state(static_cast<int>(i), columns);
    if (second_order()) {
      for (std::size_t i = 0; i < text_.velocities.size(); ++i)
        add_velocity(static_cast<int>(i), columns);
      parts_.manifold.append(StateManifold::Part::flat, velocities);
    }
    for (std::size_t i = 0; i < text_.controls.size(); ++i) {
      const Column& control = text_.controls[i];
      ExpressionValue value = inputs(1);
      value.unit = control.unit;
      if (check_name(Part::kControl, static_cast<int>(i), control.name))
        scope_.add(control.name, std::move(value));
      parts_.control_columns.push_back(control);
    }
    if (text_.kind != SystemKind::discrete) {
      time_ = parts_.graph.input(static_cast<int>(parts_.sources.size()));
      ExpressionValue value = ExpressionValue::number(time_);
      value.unit = "s";
      scope_.add("t", std::move(value));
    }
    for (std::size_t i = 0; i < text_.parameters.size(); ++i) {
      const auto& [name, number] = text_.parameters[i];
      if (check_name(Part::kParameter, static_cast<int>(i), name))
        scope_.add(name, ExpressionValue::number(parts_.graph.constant(number)));
    }
    for (std::size_t i = 0; i < text_.tables.size(); ++i) {
      const auto& [name, table] = text_.tables[i];
      if (check_name(Part::kTable, static_cast<int>(i), name))
        scope_.add_table(name, parts_.graph.add_table(table), table->arguments());
    }
    return columns;
  }

  /// Size of a state's tangent, which is that of its rate.
  static int tangent_size(ExpressionState::Kind kind) {
    switch (kind) {
      case ExpressionState::Kind::kUnitQuaternion:
        return 3;
      case ExpressionState::Kind::kPose:
        return 6;
      case ExpressionState::Kind::kNumber:
        break;
    }
    return 1;
  }

  void append_columns(std::vector<Column>& columns, const std::string& name,
                      std::initializer_list<Column> parts) {
    for (const Column& part : parts) columns.push_back({name + "/" + part.name, part.unit});
  }

  int add_state(int index, std::vector<Column>& columns) {
    const ExpressionState& state = text_.states[index];
    ExpressionValue value;
    StateManifold part;
    switch (state.kind) {
      case ExpressionState::Kind::kNumber:
        value = inputs(1);
        value.unit = state.unit;
        columns.push_back({state.name, state.unit});
        part = StateManifold::flat(1);
        break;
      case ExpressionState::Kind::kUnitQuaternion:
        value = inputs(4);
        append_columns(columns, state.name, {{"x", "1"}, {"y", "1"}, {"z", "1"}, {"w", "1"}});
        part.append(StateManifold::Part::so3);
        break;
      case ExpressionState::Kind::kPose:
        value = inputs(7);
        value.parts = {{"position", 0, 3}, {"rotation", 3, 4}};
        append_columns(columns, state.name,
                       {{"x", "m"},
                        {"y", "m"},
                        {"z", "m"},
                        {"qx", "1"},
                        {"qy", "1"},
                        {"qz", "1"},
                        {"qw", "1"}});
        part.append(StateManifold::Part::se3);
        break;
    }
    parts_.manifold.append(part);
    if (check_name(Part::kState, index, state.name)) scope_.add(state.name, std::move(value));
    return tangent_size(state.kind);
  }

  void add_velocity(int index, std::vector<Column>& columns) {
    const Column& velocity = text_.velocities[index];
    const ExpressionState::Kind kind = text_.states[index].kind;
    ExpressionValue value = inputs(tangent_size(kind));
    switch (kind) {
      case ExpressionState::Kind::kNumber:
        value.unit = velocity.unit;
        columns.push_back(velocity);
        break;
      case ExpressionState::Kind::kUnitQuaternion:
        append_columns(columns, velocity.name, {{"x", "rad/s"}, {"y", "rad/s"}, {"z", "rad/s"}});
        break;
      case ExpressionState::Kind::kPose:
        value.parts = {{"linear", 0, 3}, {"angular", 3, 3}};
        append_columns(columns, velocity.name,
                       {{"vx", "m/s"},
                        {"vy", "m/s"},
                        {"vz", "m/s"},
                        {"wx", "rad/s"},
                        {"wy", "rad/s"},
                        {"wz", "rad/s"}});
        break;
    }
    if (check_name(Part::kVelocity, index, velocity.name))
      scope_.add(velocity.name, std::move(value));
  }

  std::optional<ExpressionValue> parse(Part part, int index, const std::string& text) {
    ParsedExpression parsed = parse_expression(text, scope_, parts_.graph);
    if (!parsed.value) out_.errors.push_back({part, index, true, parsed.error});
    for (ExpressionMessage& warning : parsed.warnings)
      out_.warnings.push_back({part, index, true, std::move(warning)});
    return parsed.value;
  }

  void read_definitions() {
    for (std::size_t i = 0; i < text_.definitions.size() && out_.errors.empty(); ++i) {
      const NamedExpression& definition = text_.definitions[i];
      const bool good = check_name(Part::kDefinition, static_cast<int>(i), definition.name);
      auto value = parse(Part::kDefinition, static_cast<int>(i), definition.text);
      if (good && value) scope_.add(definition.name, std::move(*value));
    }
  }

  std::string_view equation_name() const {
    switch (text_.kind) {
      case SystemKind::second_order:
        return "acceleration";
      case SystemKind::discrete:
        return "next value";
      default:
        return "rate";
    }
  }

  void read_equations() {
    std::vector<std::string> wanted;
    for (std::size_t i = 0; i < text_.states.size(); ++i)
      wanted.push_back(second_order() ? text_.velocities[i].name : text_.states[i].name);
    std::vector<std::optional<ExpressionValue>> values(wanted.size());
    std::vector<bool> given(wanted.size(), false);
    for (std::size_t i = 0; i < text_.equations.size(); ++i) {
      const NamedExpression& equation = text_.equations[i];
      const int index = static_cast<int>(i);
      const auto found = std::find(wanted.begin(), wanted.end(), equation.name);
      if (found == wanted.end()) {
        report(Part::kEquation, index,
               fmt::format("there is no {} '{}' for this {}", second_order() ? "velocity" : "state",
                           printable(equation.name), equation_name()),
               name_hint(equation.name, wanted, second_order() ? "velocities" : "states"));
        continue;
      }
      const std::size_t of = found - wanted.begin();
      if (given[of]) {
        report(Part::kEquation, index,
               fmt::format("the {} of '{}' is given twice", equation_name(), equation.name));
        continue;
      }
      given[of] = true;
      values[of] = parse(Part::kEquation, index, equation.text);
      if (values[of]) check_type(index, text_.states[of].kind, equation.name, *values[of]);
    }
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      if (!given[i])
        report(second_order() ? Part::kVelocity : Part::kState, static_cast<int>(i),
               fmt::format("the {} of '{}' is missing", equation_name(), wanted[i]));
      if (values[i])
        parts_.outputs.insert(parts_.outputs.end(), values[i]->nodes.begin(),
                              values[i]->nodes.end());
    }
    const std::vector<NodeId> below = nodes_below(parts_.graph, parts_.outputs);
    if (time_ >= 0 && std::binary_search(below.begin(), below.end(), time_))
      clock_ = static_cast<int>(parts_.sources.size());
  }

  void check_type(int index, ExpressionState::Kind kind, const std::string& name,
                  const ExpressionValue& value) {
    const int size = tangent_size(kind);
    if (value.size() == size && value.is_number() == (size == 1) &&
        value.kind != ExpressionValue::Kind::kCondition)
      return;
    const std::string wanted = size == 1 ? "number" : fmt::format("vector of {}", size);
    out_.errors.push_back({Part::kEquation,
                           index,
                           true,
                           {0,
                            fmt::format("the {} of '{}' has to be a {}, not a {}", equation_name(),
                                        name, wanted, value.type()),
                            ""}});
  }

  /// The state gets the time, and the input that stands for it is read from there.
  void add_clock() {
    const int nx = parts_.manifold.nx(), nv = parts_.manifold.ndx() / 2;
    const int at = second_order() ? nx - nv : nx;
    auto& columns = parts_.state_columns;
    columns.insert(columns.begin() + at, {"t", "s"});
    StateManifold manifold;
    for (const ExpressionState& state : text_.states) switch (state.kind) {
        case ExpressionState::Kind::kNumber:
          manifold.append(StateManifold::flat(1));
          break;
        case ExpressionState::Kind::kUnitQuaternion:
          manifold.append(StateManifold::Part::so3);
          break;
        case ExpressionState::Kind::kPose:
          manifold.append(StateManifold::Part::se3);
          break;
      }
    manifold.append(StateManifold::Part::flat, 1);
    parts_.outputs.push_back(parts_.graph.constant(second_order() ? 0 : 1));
    if (second_order()) {
      columns.push_back({"t_rate", "s/s"});
      manifold.append(StateManifold::Part::flat, nv + 1);
    }
    parts_.manifold = manifold;
    const int added = second_order() ? 2 : 1;
    for (int& source : parts_.sources) source += source >= nx ? added : source >= at ? 1 : 0;
    parts_.sources.push_back(at);
    if (second_order()) parts_.sources.push_back(nx + 1);
  }

  const ExpressionSystemText& text_;
  ParsedExpressionSystem& out_;
  SystemParts parts_;
  ExpressionScope scope_;
  NodeId time_ = -1;
  int clock_ = -1;
};

}  // namespace

ParsedExpressionSystem make_expression_system(const ExpressionSystemText& text) {
  ParsedExpressionSystem parsed;
  SystemReader(text, parsed).read();
  return parsed;
}

}  // namespace conddp
