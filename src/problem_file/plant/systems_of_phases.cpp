#include "problem_file/plant/systems_of_phases.hpp"

#include <algorithm>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/text/spelling.hpp"
#include "problem_file/plant/closed_form_builder.hpp"
#include "problem_file/spec/expression_source.hpp"

namespace conddp {
namespace {

std::vector<std::string> names_of(const std::vector<Column>& columns) {
  std::vector<std::string> names;
  for (const Column& column : columns) names.push_back(column.name);
  return names;
}

bool is_integrated_alike(const System& a, const System& b) {
  return a.kind() == b.kind() && a.manifold().nx() == b.manifold().nx() &&
         a.manifold().ndx() == b.manifold().ndx();
}

/// Numbers of one system go over to the other as they are: where both have a unit, it is the same.
bool check_units(const NamedSystemSpec& named, const std::vector<Column>& own,
                 const std::vector<Column>& wanted, Diagnostics& out) {
  for (std::size_t i = 0; i < own.size(); ++i) {
    const std::string &unit = own[i].unit, &first = wanted[i].unit;
    if (unit == first || unit == "1" || first == "1") continue;
    out.error(named.name.place,
              fmt::format("'{}' is in {} in the first system and in {} in '{}'", own[i].name, first,
                          unit, named.name.value),
              "all systems of a file have their states and controls in the same units");
    return false;
  }
  return true;
}

/// What to do where the names of one system are not those of another.
std::string names_hint(const std::vector<std::string>& names,
                       const std::vector<std::string>& wanted) {
  const auto has_time = [](const std::vector<std::string>& list) {
    return std::find(list.begin(), list.end(), "t") != list.end();
  };
  std::string hint = "all systems of a file have the same ones, in the same order";
  if (has_time(names) != has_time(wanted))
    hint +=
        "; 't' is a state of those that depend on the time: write it in all of them, or write a "
        "state of your own with rate 1 in all of them";
  return hint;
}

/// Whether a phase can go on with the states of another system.
bool check_alike(const NamedSystemSpec& named, const System& system, const System& first,
                 Diagnostics& out) {
  const auto compare = [&](const char* what, const std::vector<Column>& own,
                           const std::vector<Column>& others) {
    const std::vector<std::string> names = names_of(own), wanted = names_of(others);
    if (names == wanted) return check_units(named, own, others, out);
    out.error(named.name.place,
              fmt::format("the {} of '{}' are {}, those of the first system {}", what,
                          named.name.value, fmt::join(names, ", "), fmt::join(wanted, ", ")),
              names_hint(names, wanted));
    return false;
  };
  if (!compare("states", system.state_columns(), first.state_columns()) ||
      !compare("controls", system.control_columns(), first.control_columns()))
    return false;
  if (is_integrated_alike(system, first)) return true;
  out.error(named.name.place,
            fmt::format("'{}' is of another kind than the first system", named.name.value),
            "all of them have rates, or all have accelerations, or all have next values");
  return false;
}

/// Reads what becomes of the states.
class JumpBuilder {
 public:
  JumpBuilder(const PhaseSpec& phase, const ProblemSpec& spec, const System& system,
              Diagnostics& out)
      : phase_(phase), spec_(spec), system_(system), out_(out) {}

  std::shared_ptr<const System> build() {
    if (!system_.manifold().curved().empty()) {
      out_.error(phase_.jump->place, "jumps need states that are numbers, without rotations");
      return nullptr;
    }
    const std::vector<std::string> names = names_of(system_.state_columns());
    if (!check_names(names)) return nullptr;
    const ParsedExpressionSystem parsed = make_expression_system(text_of(names));
    for (const ModelMessage& message : parsed.errors) report(message, Severity::kError);
    for (const ModelMessage& message : parsed.warnings) report(message, Severity::kWarning);
    return parsed.system;
  }

 private:
  bool check_names(const std::vector<std::string>& names) {
    for (const auto& [name, text] : phase_.jump->states) {
      if (std::find(names.begin(), names.end(), name.value) != names.end()) continue;
      out_.error(name.place, fmt::format("there is no state '{}' that could jump", name.value),
                 name_hint(name.value, names, "states"), names);
      return false;
    }
    return true;
  }

  /// As a system without controls, of which most states stay.
  ExpressionSystemText text_of(const std::vector<std::string>& names) {
    ExpressionSystemText text{.kind = SystemKind::discrete};
    add_names(spec_.names, text.parameters, text.tables);
    for (const Column& column : system_.state_columns())
      text.states.push_back({.name = column.name, .unit = column.unit});
    for (const auto& [name, expression] : phase_.jump->states)
      text.equations.push_back({name.value, expression.text});
    for (const std::string& name : names)
      if (std::none_of(text.equations.begin(), text.equations.end(),
                       [&](const NamedExpression& e) { return e.name == name; }))
        text.equations.push_back({name, name});
    return text;
  }

  /// Where what a message is about has its name.
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
  const System& system_;
  Diagnostics& out_;
};

/// The systems of a file by their names, those that phases name.
class SystemTable {
 public:
  SystemTable(const ProblemSpec& spec, const Plant& plant, Diagnostics& out)
      : spec_(spec), plant_(plant), out_(out) {}

  /// That of a phase that takes time; null where it does not fit the others.
  std::shared_ptr<const System> find(const PhaseSpec& phase) {
    if (!phase.system) return plant_.system;
    const auto [entry, is_new] = made_.try_emplace(phase.system->value);
    if (is_new) entry->second = make(phase.system->value);
    return entry->second;
  }

 private:
  std::shared_ptr<const System> make(const std::string& name) {
    for (const NamedSystemSpec& named : spec_.systems) {
      if (named.name.value != name) continue;
      auto system = make_system(named.system, spec_, out_);
      return system && check_alike(named, *system, *plant_.system, out_) ? system : nullptr;
    }
    return nullptr;
  }

  const ProblemSpec& spec_;
  const Plant& plant_;
  Diagnostics& out_;
  std::map<std::string, std::shared_ptr<const System>> made_;
};

}  // namespace

bool add_systems_of_phases(const ProblemSpec& spec, Plant& plant, Diagnostics& out) {
  if (spec.systems.empty() && !spec.has_jumps()) return true;
  SystemTable systems(spec, plant, out);
  for (const PhaseSpec& phase : spec.phases)
    plant.systems.push_back(phase.jump ? JumpBuilder(phase, spec, *plant.system, out).build()
                                       : systems.find(phase));
  return std::find(plant.systems.begin(), plant.systems.end(), nullptr) == plant.systems.end();
}

}  // namespace conddp
