#include "problem_file/plant/united_systems.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "problem_file/plant/closed_form_builder.hpp"
#include "systems/system.hpp"

namespace conddp {
namespace {

using Systems = std::vector<UsedSystem>;

std::vector<std::string> names_of(const std::vector<Column>& columns) {
  std::vector<std::string> names;
  for (const Column& column : columns) names.push_back(column.name);
  return names;
}

/// The systems that phases name, each once. Empty if one of them cannot be made.
Systems named_systems(const ProblemSpec& spec, Diagnostics& out) {
  Systems used;
  for (const PhaseSpec& phase : spec.phases) {
    if (!phase.system) continue;
    const auto named = std::ranges::find(spec.systems, phase.system->value,
                                         [](const NamedSystemSpec& s) { return s.name.value; });
    const bool is_known =
        std::ranges::any_of(used, [&](const UsedSystem& known) { return known.named == &*named; });
    if (is_known) continue;
    auto system = make_system(named->system, spec, out);
    if (!system) return {};
    used.push_back({&*named, std::move(system)});
    if (const auto* own = std::get_if<ExpressionSystemSpec>(&named->system.parameters))
      used.back().text = own->text;
  }
  return used;
}

/// Checks units: values pass unchanged between systems, so units must agree wherever both are
/// given.
bool check_units(const Systems& systems, const std::vector<Column>& (System::*columns)() const,
                 Diagnostics& out) {
  std::vector<std::pair<Column, const UsedSystem*>> known;
  for (const UsedSystem& used : systems)
    for (const Column& own : (used.system.get()->*columns)()) {
      if (own.unit == "1") continue;
      const auto first = std::ranges::find_if(
          known, [&](const auto& entry) { return entry.first.name == own.name; });
      if (first == known.end()) {
        known.emplace_back(own, &used);
        continue;
      }
      if (first->first.unit == own.unit) continue;
      out.error(used.named->name.place,
                fmt::format("'{}' is in {} in '{}' and in {} in '{}'", own.name, first->first.unit,
                            first->second->named->name.value, own.unit, used.named->name.value),
                "all systems of a file have their states and controls in the same units");
      return false;
    }
  return true;
}

bool have_same_states(const System& a, const System& b) {
  return names_of(a.state_columns()) == names_of(b.state_columns());
}

/// Checks that two systems have the same kind of step.
bool check_kind(const UsedSystem& used, const System& first, Diagnostics& out) {
  const System& system = *used.system;
  if (system.kind() == first.kind() && system.ndx() == first.ndx()) return true;
  out.error(used.named->name.place,
            fmt::format("'{}' is of another kind than the first system", used.named->name.value),
            "all of them have rates, or all have accelerations, or all have next values");
  return false;
}

/// The text of a system that can get additional states; null for other systems.
const ExpressionSystemText* extensible_text(const UsedSystem& used) {
  const auto* system = std::get_if<ExpressionSystemSpec>(&used.named->system.parameters);
  return system != nullptr && system->text.kind != SystemKind::second_order ? &system->text
                                                                            : nullptr;
}

/// Gives systems of expressions the states of all systems.
class StateUnion {
 public:
  StateUnion(Systems& systems, Diagnostics& out) : systems_(systems), out_(out) {}

  bool extend() {
    for (const UsedSystem& used : systems_)
      if (!add_states(used)) return false;
    const bool clock = std::ranges::any_of(systems_, has_clock);
    for (UsedSystem& used : systems_)
      if (!extend(used, clock)) return false;
    return true;
  }

 private:
  bool add_states(const UsedSystem& used) {
    const ExpressionSystemText* text = extensible_text(used);
    if (text == nullptr) return report_states();
    return check_texts(*text, used) && std::ranges::all_of(text->states, [&](const auto& state) {
             return add_state(state, used);
           });
  }

  bool check_texts(const ExpressionSystemText& text, const UsedSystem& used) const {
    const ExpressionSystemText* first = extensible_text(systems_.front());
    if (text.kind == first->kind) return true;
    return check_kind(used, *systems_.front().system, out_);
  }

  bool add_state(const ExpressionState& state, const UsedSystem& used) {
    const auto known = std::ranges::find(states_, state.name, &ExpressionState::name);
    if (known == states_.end()) {
      states_.push_back(state);
      return true;
    }
    if (known->unit == "1") known->unit = state.unit;
    if (known->kind == state.kind) return true;
    out_.error(used.named->name.place,
               fmt::format("'{}' is a number in one system and a rotation or a pose in another",
                           state.name),
               "a state is the same in all systems that have it");
    return false;
  }

  /// Reports systems whose states differ from those of the first and cannot be extended.
  bool report_states() const {
    const UsedSystem& first = systems_.front();
    const auto other = std::ranges::find_if(systems_, [&](const UsedSystem& used) {
      return !have_same_states(*used.system, *first.system);
    });
    out_.error(other->named->name.place,
               fmt::format("the states of '{}' are {}, those of '{}' {}", other->named->name.value,
                           fmt::join(names_of(other->system->state_columns()), ", "),
                           first.named->name.value,
                           fmt::join(names_of(first.system->state_columns()), ", ")),
               "systems with different states are given by 'rate' or by 'next'; all others have "
               "the same states in the same order");
    return false;
  }

  static bool has_clock(const UsedSystem& used) {
    const auto& columns = used.system->state_columns();
    const bool of_text =
        std::ranges::any_of(extensible_text(used)->states,
                            [](const ExpressionState& state) { return state.name == kClock; });
    return std::ranges::find(columns, kClock, &Column::name) != columns.end() && !of_text;
  }

  bool extend(UsedSystem& used, bool clock) const {
    ExpressionSystemText text = *extensible_text(used);
    const std::vector<ExpressionState> own = std::move(text.states);
    text.states = states_;
    for (ExpressionState& state : text.states)
      state.hidden = std::ranges::find(own, state.name, &ExpressionState::name) == own.end();
    text.clock = clock;
    const ParsedExpressionSystem parsed = make_expression_system(text);
    for (const ModelMessage& message : parsed.errors)
      out_.error(used.named->name.place, message.message.message, message.message.hint);
    used.system = parsed.system;
    used.text = std::move(text);
    return used.system != nullptr;
  }

  Systems& systems_;
  Diagnostics& out_;
  std::vector<ExpressionState> states_;
};

}  // namespace

std::vector<UsedSystem> unite_systems(const ProblemSpec& spec, Diagnostics& out) {
  Systems systems = named_systems(spec, out);
  if (systems.empty() || !check_units(systems, &System::state_columns, out) ||
      !check_units(systems, &System::control_columns, out))
    return {};
  const System& first = *systems.front().system;
  const bool same_states = std::ranges::all_of(
      systems, [&](const UsedSystem& used) { return have_same_states(*used.system, first); });
  if (!same_states && !StateUnion(systems, out).extend()) return {};
  for (const UsedSystem& used : systems)
    if (!check_kind(used, *systems.front().system, out)) return {};
  return systems;
}

std::vector<Column> controls_of(const std::vector<UsedSystem>& systems) {
  std::vector<Column> controls;
  for (const UsedSystem& used : systems)
    for (const Column& control : used.system->control_columns())
      if (std::ranges::find(controls, control.name, &Column::name) == controls.end())
        controls.push_back(control);
  return controls;
}

bool have_same_columns(const System& a, const System& b) {
  if (!have_same_states(a, b)) return false;
  for (int i = 0; i < a.nx(); ++i)
    if (a.has_state(i) != b.has_state(i)) return false;
  return names_of(a.control_columns()) == names_of(b.control_columns());
}

}  // namespace conddp
