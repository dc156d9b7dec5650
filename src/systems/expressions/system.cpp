#include "systems/expressions/system.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "base/text/utf8.hpp"
#include "systems/graphs/compiled_system.hpp"
#include "systems/graphs/derivatives.hpp"

namespace conddp {
namespace {

/// Reads the texts of a system.
class SystemReader {
 public:
  using Part = ModelMessage::Part;

  SystemReader(const ExpressionSystemText& text, ParsedExpressionSystem& out)
      : text_(text),
        out_(out),
        texts_(parts_.graph, text.kind != SystemKind::discrete, out.errors, out.warnings) {
    parts_.kind = text.kind;
  }

  void read() {
    if (!check_sizes()) return;
    // Stops after the first group of errors, because later texts depend on the earlier names.
    parts_.state_columns = add_names();
    if (texts_.good()) texts_.add_definitions(text_.definitions);
    if (texts_.good()) read_equations();
    if (texts_.good() && !out_.reads_phase_times) finish();
  }

 private:
  bool check_sizes() {
    if (text_.states.empty()) {
      texts_.report(Part::kWhole, 0, "the system has no states");
      return false;
    }
    if (!second_order() || text_.velocities.size() == text_.states.size()) return true;
    texts_.report(Part::kWhole, 0,
                  fmt::format("there are {} and {}", counted(text_.states.size(), "position"),
                              text_.velocities.size() == 1
                                  ? "1 velocity"
                                  : fmt::format("{} velocities", text_.velocities.size())));
    return false;
  }

  /// Builds the system from the texts.
  void finish() {
    if (clock_ >= 0) add_clock();
    if (is_too_large())
      return texts_.report(Part::kWhole, 0, "the expressions of the system are too large");
    out_.usual_state = parts_.manifold.neutral();
    if (clock_ >= 0 && second_order()) out_.usual_state[parts_.manifold.nx() - 1 - durations()] = 1;
    out_.system = compile_system(std::move(parts_));
  }

  bool second_order() const { return text_.kind == SystemKind::second_order; }
  int durations() const {
    return text_.times ? static_cast<int>(text_.times->durations.size()) : 0;
  }

  bool is_too_large() {
    InputMotions motions;  // The motion of each number on its own, as in a flat state.
    for (std::size_t i = 0; i < parts_.sources.size(); ++i)
      motions.push_back({{static_cast<int>(i), parts_.graph.constant(1)}});
    return count_derivatives(parts_.graph, parts_.outputs, motions) > kMostDerivatives;
  }

  /// Adds `count` inputs and returns them as a value.
  ExpressionValue inputs(int count) {
    std::vector<NodeId> nodes;
    for (int i = 0; i < count; ++i) {
      nodes.push_back(parts_.graph.input(static_cast<int>(parts_.sources.size())));
      parts_.sources.push_back(static_cast<int>(parts_.sources.size()));
    }
    return count == 1 ? ExpressionValue::number(nodes[0]) : ExpressionValue::vector(nodes);
  }

  /// Adds the names of states, velocities, controls, the clock, parameters and tables. Returns the
  /// columns of the state.
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
      texts_.add(Part::kControl, static_cast<int>(i), control.name, std::move(value));
      parts_.control_columns.push_back(control);
    }
    if (text_.kind != SystemKind::discrete) {
      time_ = parts_.graph.input(static_cast<int>(parts_.sources.size()));
      ExpressionValue value = ExpressionValue::number(time_);
      value.unit = "s";
      texts_.scope().add(kClock, std::move(value));
      add_phase_times();
    } else {
      for (const char* name : {kClock, kPhaseTime, kFinalTime})
        texts_.scope().explain(
            name, "difference equations have no time; a state can count: 'next: {n: n + 1}'");
    }
    texts_.add_parameters(text_.parameters);
    texts_.add_tables(text_.tables);
    for (const auto& [name, table] : text_.tables) parts_.tables.push_back(name);
    return columns;
  }

  static constexpr const char *kPhaseTime = "phase_time", *kFinalTime = "final_time";

  /// True if the text uses the name for something else.
  bool has_name(std::string_view name) {
    const auto in = [&](const auto& list, const auto& name_of) {
      return std::ranges::find(list, name, name_of) != list.end();
    };
    const auto first = [](const auto& entry) -> const std::string& { return entry.first; };
    return texts_.scope().find(name) != nullptr || in(text_.parameters, first) ||
           in(text_.tables, first) || in(text_.definitions, &NamedExpression::name);
  }

  /// Free durations are inputs after the time. If no times are given, two inputs stand in for them
  /// and reveal whether the equations depend on them.
  void add_phase_times() {
    ExpressionGraph& graph = parts_.graph;
    const int next = static_cast<int>(parts_.sources.size()) + 1;
    const auto add = [&](const char* name, NodeId node) {
      if (has_name(name)) return;
      ExpressionValue value = ExpressionValue::number(node);
      value.unit = "s";
      texts_.scope().add(name, std::move(value));
    };
    if (!text_.times) {
      stand_ins_ = {graph.input(next), graph.input(next + 1)};
      add(kPhaseTime, stand_ins_[0]);
      add(kFinalTime, stand_ins_[1]);
      return;
    }
    NodeId begin = graph.constant(text_.times->begin), final = graph.constant(text_.times->final);
    for (int i = 0; i < durations(); ++i) {
      const NodeId duration = graph.input(next + i);
      if (text_.times->before[i]) begin = graph.add(begin, duration);
      final = graph.add(final, duration);
    }
    add(kPhaseTime, graph.subtract(time_, begin));
    add(kFinalTime, final);
  }

  /// Size of a state's tangent, and thus of its rate.
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

  static StateManifold manifold_of(ExpressionState::Kind kind) {
    StateManifold manifold;
    switch (kind) {
      case ExpressionState::Kind::kNumber:
        return StateManifold::flat(1);
      case ExpressionState::Kind::kUnitQuaternion:
        manifold.append(StateManifold::Part::so3);
        break;
      case ExpressionState::Kind::kPose:
        manifold.append(StateManifold::Part::se3);
        break;
    }
    return manifold;
  }

  void append_columns(std::vector<Column>& columns, const std::string& name,
                      std::initializer_list<Column> parts) {
    for (const Column& part : parts) columns.push_back({name + "/" + part.name, part.unit});
  }

  int add_state(int index, std::vector<Column>& columns) {
    const ExpressionState& state = text_.states[index];
    ExpressionValue value;
    switch (state.kind) {
      case ExpressionState::Kind::kNumber:
        value = inputs(1);
        value.unit = state.unit;
        columns.push_back({state.name, state.unit});
        break;
      case ExpressionState::Kind::kUnitQuaternion:
        value = inputs(4);
        append_columns(columns, state.name, {{"x", "1"}, {"y", "1"}, {"z", "1"}, {"w", "1"}});
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
        break;
    }
    parts_.manifold.append(manifold_of(state.kind));
    states_.push_back(value.nodes);
    if (!state.hidden) texts_.add(Part::kState, index, state.name, std::move(value));
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
    texts_.add(Part::kVelocity, index, velocity.name, std::move(value));
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
    for (std::size_t i = 0; i < text_.states.size(); ++i)
      wanted_.push_back(second_order() ? text_.velocities[i].name : text_.states[i].name);
    std::vector<std::optional<ExpressionValue>> values(wanted_.size());
    std::vector<bool> given(wanted_.size(), false);
    for (std::size_t i = 0; i < text_.equations.size(); ++i) {
      const int index = static_cast<int>(i);
      const auto of = find_state(index, given);
      if (!of) continue;
      given[*of] = true;
      values[*of] = texts_.parse(Part::kEquation, index, text_.equations[i].text);
      if (values[*of]) check_type(index, text_.states[*of].kind, wanted_[*of], *values[*of]);
    }
    for (std::size_t i = 0; i < wanted_.size(); ++i)
      if (!given[i] && !text_.states[i].hidden)
        texts_.report(second_order() ? Part::kVelocity : Part::kState, static_cast<int>(i),
                      fmt::format("the {} of '{}' is missing", equation_name(), wanted_[i]));
    set_at_rest(given);
    set_outputs(values);
  }

  /// Finds the hidden states without an equation, which are at rest.
  void set_at_rest(const std::vector<bool>& given) {
    for (std::size_t i = 0; i < given.size(); ++i)
      if (text_.states[i].hidden && !given[i]) at_rest_.push_back(i);
    if (at_rest_.empty()) return;
    for (std::size_t i = 0; i < given.size(); ++i)
      parts_.at_rest.insert(parts_.at_rest.end(), manifold_of(text_.states[i].kind).nx(),
                            text_.states[i].hidden && !given[i]);
  }

  /// The rows of a state at rest: the state itself as its next value, or the rate 0.
  std::vector<NodeId> resting(std::size_t state) {
    if (text_.kind == SystemKind::discrete) return states_[state];
    return std::vector(tangent_size(text_.states[state].kind), parts_.graph.constant(0));
  }

  /// Sets the outputs to the results of the equations, and marks the clock as needed if they depend
  /// on time.
  void set_outputs(const std::vector<std::optional<ExpressionValue>>& values) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      std::vector<NodeId> nodes;
      if (values[i])
        nodes = values[i]->nodes;
      else if (std::ranges::find(at_rest_, i) != at_rest_.end())
        nodes = resting(i);
      parts_.outputs.insert(parts_.outputs.end(), nodes.begin(), nodes.end());
    }
    const std::vector<NodeId> below = nodes_below(parts_.graph, parts_.outputs);
    const auto depends_on = [&](NodeId id) {
      return std::binary_search(below.begin(), below.end(), id);
    };
    out_.reads_phase_times = std::ranges::any_of(stand_ins_, depends_on);
    if (time_ >= 0 && (text_.clock || text_.times || depends_on(time_)))
      clock_ = static_cast<int>(parts_.sources.size());
  }

  /// The state whose rate an equation gives. Nothing, with an error, if the state is unknown or
  /// already has an equation.
  std::optional<std::size_t> find_state(int equation, const std::vector<bool>& given) {
    const std::string& name = text_.equations[equation].name;
    const auto found = std::find(wanted_.begin(), wanted_.end(), name);
    if (found == wanted_.end()) {
      texts_.report(
          Part::kEquation, equation,
          fmt::format("there is no {} '{}' for this {}", second_order() ? "velocity" : "state",
                      printable(name), equation_name()),
          name_hint(name, wanted_, second_order() ? "velocities" : "states"));
      return std::nullopt;
    }
    const std::size_t state = found - wanted_.begin();
    if (!given[state]) return state;
    texts_.report(Part::kEquation, equation,
                  fmt::format("the {} of '{}' is given twice", equation_name(), name));
    return std::nullopt;
  }

  void check_type(int index, ExpressionState::Kind kind, const std::string& name,
                  const ExpressionValue& value) {
    const int size = tangent_size(kind);
    if (value.size() == size && value.is_number() == (size == 1) &&
        value.kind != ExpressionValue::Kind::kCondition)
      return;
    const std::string wanted = size == 1 ? "number" : fmt::format("vector of {}", size);
    texts_.report_text(Part::kEquation, index,
                       fmt::format("the {} of '{}' has to be a {}, not a {}", equation_name(), name,
                                   wanted, value.type()));
  }

  /// Appends the time and free durations to the state, and redirects the inputs that stand for
  /// them.
  void add_clock() {
    const int nx = parts_.manifold.nx(), nv = parts_.manifold.ndx() / 2;
    const int at = second_order() ? nx - nv : nx, added = 1 + durations();
    auto& columns = parts_.state_columns;
    std::vector<Column> times{{kClock, "s", true}}, rates{{kClockRate, "s/s", true}};
    for (int i = 0; i < durations(); ++i) {
      const std::string& name = text_.times->durations[i];
      times.push_back({name, "s", true});
      rates.push_back({name + "_rate", "s/s", true});
    }
    columns.insert(columns.begin() + at, times.begin(), times.end());
    if (!parts_.at_rest.empty()) parts_.at_rest.insert(parts_.at_rest.end(), added, false);
    StateManifold manifold;
    for (const ExpressionState& state : text_.states) manifold.append(manifold_of(state.kind));
    manifold.append(StateManifold::Part::flat, added);
    for (int i = 0; i < added; ++i)
      parts_.outputs.push_back(parts_.graph.constant(second_order() || i > 0 ? 0 : 1));
    if (second_order()) {
      columns.insert(columns.end(), rates.begin(), rates.end());
      manifold.append(StateManifold::Part::flat, nv + added);
    }
    parts_.manifold = manifold;
    for (int& source : parts_.sources)
      source += source >= nx && second_order() ? 2 * added : source >= at ? added : 0;
    for (int i = 0; i < added; ++i) parts_.sources.push_back(at + i);
    for (int i = 0; second_order() && i < added; ++i) parts_.sources.push_back(nx + added + i);
  }

  const ExpressionSystemText& text_;
  ParsedExpressionSystem& out_;
  ExpressionSystemParts parts_;
  ModelTextReader texts_;
  std::vector<std::vector<NodeId>> states_;  ///< inputs of each state
  std::vector<std::string> wanted_;   ///< left-hand sides of equations, one name for each state
  std::vector<std::size_t> at_rest_;  ///< indices of states at rest
  NodeId time_ = -1;
  std::vector<NodeId> stand_ins_;  ///< inputs for phase time and final time if these are not given
  int clock_ = -1;
};

}  // namespace

ParsedExpressionSystem make_expression_system(const ExpressionSystemText& text) {
  ParsedExpressionSystem parsed;
  SystemReader(text, parsed).read();
  if (!parsed.reads_phase_times) return parsed;
  // Reads the text once more without stand-ins, as a phase that begins with the motion.
  ExpressionSystemText whole = text;
  whole.times.emplace();
  ParsedExpressionSystem of_phase = make_expression_system(whole);
  parsed.system = std::move(of_phase.system);
  parsed.usual_state = std::move(of_phase.usual_state);
  if (parsed.errors.empty()) parsed.errors = std::move(of_phase.errors);
  return parsed;
}

}  // namespace conddp
