#include "problem_file/plant/systems_of_phases.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "problem_file/model/expression_source.hpp"
#include "problem_file/model/phase_grid.hpp"
#include "problem_file/plant/united_systems.hpp"
#include "systems/expressions/scope.hpp"
#include "systems/system.hpp"

namespace conddp {
namespace {

/// Reads the new state values after a jump, as functions of the states before it.
class JumpBuilder {
 public:
  JumpBuilder(const PhaseSpec& phase, const ProblemSpec& spec, const System& before,
              Diagnostics& out)
      : phase_(phase), spec_(spec), before_(before), out_(out) {}

  std::shared_ptr<const System> build() {
    if (!before_.manifold().curved().empty()) {
      out_.error(phase_.jump->place, "jumps need states that are numbers, without rotations");
      return nullptr;
    }
    for (int i = 0; i < before_.nx(); ++i) {
      const std::string& name = before_.state_columns()[i].name;
      if (is_hidden(i) || is_expression_name(name)) continue;
      out_.error(phase_.jump->place,
                 fmt::format("jumps need states with names of expressions, and '{}' is none", name),
                 "write the system as equations: 'states: {x: m, v: m/s}'");
      return nullptr;
    }
    if (!check_names()) return nullptr;
    const ParsedExpressionSystem parsed = make_expression_system(text());
    for (const ModelMessage& message : parsed.errors) report(message, Severity::kError);
    for (const ModelMessage& message : parsed.warnings) report(message, Severity::kWarning);
    return parsed.system;
  }

 private:
  bool jumps(const std::string& state) const {
    return std::ranges::any_of(phase_.jump->states,
                               [&](const auto& entry) { return entry.first.value == state; });
  }

  /// True for states without a name in expressions.
  bool is_hidden(int state) const {
    return !before_.has_state(state) ||
           before_.state_columns()[state].name.starts_with(kDurationColumn);
  }

  bool check_names() {
    std::vector<std::string> names;
    for (const Column& column : before_.state_columns()) names.push_back(column.name);
    for (const auto& [name, text] : phase_.jump->states) {
      if (std::find(names.begin(), names.end(), name.value) != names.end()) continue;
      out_.error(name.place, fmt::format("there is no state '{}' that could jump", name.value),
                 name_hint(name.value, names, "states"), names);
      return false;
    }
    return true;
  }

  /// A system without controls; most states stay. Expressions use the states before the jump,
  /// without free durations.
  ExpressionSystemText text() {
    ExpressionSystemText text{.kind = SystemKind::discrete};
    add_names(spec_.names, text.parameters, text.tables);
    for (const auto& [name, expression] : phase_.jump->states)
      text.equations.push_back({name.value, expression.text});
    for (int i = 0; i < before_.nx(); ++i) {
      const Column& column = before_.state_columns()[i];
      const bool hidden = is_hidden(i);
      text.states.push_back({.name = column.name, .unit = column.unit, .hidden = hidden});
      if (!hidden && !jumps(column.name)) text.equations.push_back({column.name, column.name});
    }
    return text;
  }

  /// Place of the name that a message concerns.
  const Place& place_of(const ModelMessage& message) const {
    using Part = ModelMessage::Part;
    const auto& states = phase_.jump->states;
    const std::size_t index = message.index;
    if (message.part == Part::kEquation && index < states.size()) return states[index].first.place;
    if (message.part == Part::kParameter) return spec_.names.parameter_places.at(index);
    if (message.part == Part::kTable) return spec_.names.tables.at(index).name.place;
    return phase_.jump->place;
  }

  void report(const ModelMessage& message, Severity severity) {
    const auto& states = phase_.jump->states;
    const bool written = message.part == ModelMessage::Part::kEquation &&
                         message.index < static_cast<int>(states.size());
    if (written && message.in_text)
      return report_expression(states[message.index].second, message.message, severity, out_);
    if (severity == Severity::kError)
      out_.error(place_of(message), message.message.message, message.message.hint);
  }

  const PhaseSpec& phase_;
  const ProblemSpec& spec_;
  const System& before_;
  Diagnostics& out_;
};

/// True if equations of a file depend on the phase time or on the final time.
bool reads_phase_times(const ProblemSpec& spec) {
  const auto reads = [](const SystemSpec& system) {
    const auto* equations = std::get_if<ExpressionSystemSpec>(&system.parameters);
    return equations != nullptr && equations->parsed.reads_phase_times;
  };
  return (spec.system && reads(*spec.system)) ||
         std::ranges::any_of(spec.systems, [&](const auto& named) { return reads(named.system); });
}

/// Times that the equations of a phase can name.
SystemTimes times_of(std::size_t phase, const ProblemSpec& spec) {
  SystemTimes times;
  for (const auto& [name, value] : spec.initial_state.values)
    if (name.value == kClock) times.begin = times.final = value;
  for (std::size_t p = 0; p < spec.phases.size(); ++p) {
    const PhaseSpec& other = spec.phases[p];
    if (other.takes_no_time()) continue;
    if (other.free_duration) {
      times.durations.push_back(std::string(kDurationColumn) + other.name.value);
      times.before.push_back(p < phase);
      continue;
    }
    const double duration = phase_duration(other);
    times.final += duration;
    if (p < phase) times.begin += duration;
  }
  return times;
}

/// A system of equations with the times of a phase. Null with an error at `place`, because the text
/// is not the file's.
std::shared_ptr<const System> with_times(ExpressionSystemText text, std::size_t phase,
                                         const ProblemSpec& spec, const Place& place, Plant& plant,
                                         Diagnostics& out) {
  text.times = times_of(phase, spec);
  ParsedExpressionSystem parsed = make_expression_system(text);
  for (const ModelMessage& message : parsed.errors)
    out.error(place, message.message.message, message.message.hint);
  plant.usual_state = std::move(parsed.usual_state);
  return parsed.system;
}

/// For a file with one system: adds the times of each phase; otherwise the systems are equal.
bool add_times_of_phases(const ProblemSpec& spec, Plant& plant,
                         std::vector<std::shared_ptr<const System>>& at_nodes, Diagnostics& out) {
  const ExpressionSystemText& text = std::get<ExpressionSystemSpec>(spec.system->parameters).text;
  for (std::size_t p = 0; p < at_nodes.size(); ++p) {
    at_nodes[p] = with_times(text, p, spec, spec.system->place, plant, out);
    if (at_nodes[p] == nullptr) return false;
  }
  plant.system = at_nodes.back();
  return true;
}

/// Index of the system that defines the states at the beginning of each phase and at the last node.
/// A jump has the states of the phase before it.
std::vector<std::size_t> systems_at_nodes(const ProblemSpec& spec,
                                          const std::vector<UsedSystem>& systems) {
  std::vector<std::size_t> at_nodes;
  std::size_t system = 0;  // of the first phase that takes time
  for (const PhaseSpec& phase : spec.phases) {
    if (phase.system)
      system = std::ranges::find(systems, phase.system->value,
                                 [](const UsedSystem& s) { return s.named->name.value; }) -
               systems.begin();
    at_nodes.push_back(system);
  }
  at_nodes.push_back(system);
  return at_nodes;
}

/// Reports features that carry controls from phase to phase, which needs the same controls in all
/// systems.
bool check_memory(const UsedSystem& used, const ProblemSpec& spec, Diagnostics& out) {
  const std::string_view use =
      spec.has_linear_controls() ? "controls: linear" : spec.use_of_previous_control();
  if (use.empty()) return true;
  out.error(used.named->name.place,
            fmt::format("'{}' does not have the controls of all systems, and '{}' needs the same "
                        "ones in all of them",
                        used.named->name.value, use));
  return false;
}

/// Adds variants for phases whose systems have different states or controls.
bool add_variants(const ProblemSpec& spec, const std::vector<UsedSystem>& systems,
                  const std::vector<std::size_t>& at_nodes, Plant& plant, Diagnostics& out) {
  std::vector<SystemVariant> variants;
  std::vector<std::size_t> variant_of;  // by system
  for (const UsedSystem& used : systems) {
    const auto known = std::ranges::find_if(variants, [&](const SystemVariant& variant) {
      return have_same_columns(*variant.system, *used.system);
    });
    variant_of.push_back(known - variants.begin());
    if (known == variants.end()) variants.push_back({used.named->name.value, used.system});
  }
  if (variants.size() < 2) return true;
  plant.controls = controls_of(systems);
  for (const UsedSystem& used : systems) {
    const bool has_all = std::ranges::equal(used.system->control_columns(), plant.controls, {},
                                            &Column::name, &Column::name);
    if (!has_all && !check_memory(used, spec, out)) return false;
  }
  plant.variants = std::move(variants);
  for (const std::size_t system : at_nodes) plant.variant_at.push_back(variant_of[system]);
  return true;
}

}  // namespace

bool add_systems_of_phases(const ProblemSpec& spec, Plant& plant, Diagnostics& out) {
  const bool times = reads_phase_times(spec);
  if (spec.systems.empty() && !spec.has_jumps() && !times) return true;
  std::vector<std::shared_ptr<const System>> at_nodes(spec.phases.size() + 1, plant.system);
  if (times && spec.systems.empty() && !add_times_of_phases(spec, plant, at_nodes, out))
    return false;
  if (!spec.systems.empty()) {
    std::vector<UsedSystem> systems = unite_systems(spec, out);
    if (systems.empty()) return false;
    for (UsedSystem& used : systems)
      if (times && used.text)
        used.system = with_times(*used.text, 0, spec, used.named->name.place, plant, out);
    const std::vector<std::size_t> numbers = systems_at_nodes(spec, systems);
    if (!add_variants(spec, systems, numbers, plant, out)) return false;
    for (std::size_t node = 0; node < at_nodes.size(); ++node) {
      const UsedSystem& used = systems[numbers[node]];
      at_nodes[node] = times && used.text
                           ? with_times(*used.text, node, spec, used.named->name.place, plant, out)
                           : used.system;
    }
    plant.system = systems.front().system;
    // Added states and an added clock begin at zero.
    if (static_cast<int>(plant.usual_state.size()) != plant.system->nx()) plant.usual_state.clear();
  }
  for (std::size_t p = 0; p < spec.phases.size(); ++p)
    plant.systems.push_back(spec.phases[p].jump
                                ? JumpBuilder(spec.phases[p], spec, *at_nodes[p], out).build()
                                : at_nodes[p]);
  return std::find(plant.systems.begin(), plant.systems.end(), nullptr) == plant.systems.end();
}

}  // namespace conddp
