#include "problem_file/assemble/initial_choice.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "problem_file/model/components.hpp"
#include "problem_file/model/phase_grid.hpp"

namespace conddp {
namespace {

/// Reports conflicts of free durations with other keys, at the place of the duration.
bool check_free_durations(const ProblemSpec& spec, const System& system, Diagnostics& out) {
  const PhaseSpec* free = spec.first_free_duration();
  if (free == nullptr) return true;
  const int errors = out.error_count();
  const Place& place = free->free_duration->place;
  if (spec.stepping && spec.stepping->scheme == SteppingScheme::variational_midpoint)
    out.error(place, "steps of the variational midpoint rule have one given length");
  else if (system.kind() == SystemKind::discrete)
    out.error(place, "difference equations have no time, so durations are not free");
  return out.error_count() == errors;
}

/// Adds the free durations as further controls of the choice.
void add_durations(const ProblemSpec& spec, InitialChoice& choice, std::vector<Column>& controls) {
  for (const PhaseSpec& phase : spec.phases) {
    auto& free = choice.durations.emplace_back();
    if (!phase.free_duration) continue;
    free = {.choice = static_cast<int>(controls.size()), .written = phase_duration(phase)};
    choice.lower.push_back(phase.free_duration->lower);
    choice.upper.push_back(phase.free_duration->upper);
    controls.push_back({std::string(kDurationColumn) + phase.name.value, "s"});
  }
}

/// False, with an error, if a residual needs a free initial state.
bool check_given_start(const CostSpec* cycle, Diagnostics& out) {
  if (cycle == nullptr) return true;
  out.error(
      cycle->residual.place,
      fmt::format("the residual '{}' needs a free initial state, but it is given",
                  cycle->residual.value),
      "write '- {choose: all}' as the first of the phases; 'conddp check --expand' writes out "
      "those of a gait");
  return false;
}

/// Adds the coordinates that the first phase chooses, with their bounds, and the names of these
/// controls. False, with an error, if bounds are inconsistent.
bool add_coordinates(const PhaseSpec& phase, const ComponentNames& names, InitialChoice& choice,
                     std::vector<Column>& controls, Diagnostics& out) {
  const auto chosen = resolve(phase.choice->coordinates, names, 0.0, out);
  const auto lower = resolve(phase.choice->lower, names, -kUnlimited, out);
  const auto upper = resolve(phase.choice->upper, names, kUnlimited, out);
  if (!chosen || !lower || !upper) return false;
  for (int i = 0; i < names.size(); ++i) {
    if ((*chosen)[i] == 0) continue;
    if ((*lower)[i] > (*upper)[i]) {
      out.error(phase.knots.place,
                fmt::format("for '{}' the lower bound {} lies above the upper bound {}",
                            names.names[i], (*lower)[i], (*upper)[i]));
      return false;
    }
    choice.coordinates.push_back(i);
    choice.lower.push_back((*lower)[i]);
    choice.upper.push_back((*upper)[i]);
    controls.push_back({names.names[i], ""});
  }
  return true;
}

/// Adds the first linear controls. Their bounds are those of the knots.
void add_first_controls(const System& actuated, InitialChoice& choice,
                        std::vector<Column>& controls) {
  choice.first_controls = actuated.nu();
  controls.insert(controls.end(), actuated.control_columns().begin(),
                  actuated.control_columns().end());
  choice.lower.resize(controls.size(), -kUnlimited);
  choice.upper.resize(controls.size(), kUnlimited);
}

/// Coordinates of a state that are durations, each with the control that chooses it.
std::vector<std::pair<int, int>> durations_in_state(const System& system,
                                                    const std::vector<Column>& controls) {
  std::vector<std::pair<int, int>> list;
  const std::vector<std::string> names = tangent_names(system).names;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!names[i].starts_with(kDurationColumn)) continue;
    const auto control = std::ranges::find(controls, names[i], &Column::name);
    if (control != controls.end())
      list.emplace_back(static_cast<int>(i), static_cast<int>(control - controls.begin()));
  }
  return list;
}

/// Adds the control before the first one; in a periodic motion it equals the one at the end.
void add_previous_controls(const System& actuated, InitialChoice& choice,
                           std::vector<Column>& controls) {
  choice.previous_controls = actuated.nu();
  for (const Column& control : actuated.control_columns())
    controls.push_back({"previous/" + control.name, control.unit});
  choice.lower.resize(controls.size(), -kUnlimited);
  choice.upper.resize(controls.size(), kUnlimited);
}

/// Choice of the first phase; empty, with an error, if it is invalid.
std::optional<InitialChoice> make_choice(const ProblemSpec& spec, const Plant& plant,
                                         const std::vector<double>& state, bool previous,
                                         bool cycle, Diagnostics& out) {
  const PhaseSpec& phase = spec.phases.front();
  const System& system = *plant.system;
  InitialChoice choice{.system = nullptr, .state = state};
  std::vector<Column> controls;
  if (!add_coordinates(phase, tangent_names(system), choice, controls, out)) return std::nullopt;
  add_durations(spec, choice, controls);
  const bool durations = controls.size() > choice.coordinates.size();
  const bool first_controls = spec.has_linear_controls() && !spec.initial_state.previous_control;
  if (first_controls) add_first_controls(plant.actuated(), choice, controls);
  if (cycle && previous) add_previous_controls(plant.actuated(), choice, controls);
  if (controls.empty()) {
    out.error(phase.knots.place, "no component of the state is chosen",
              "leave the phase out, or write 'choose: all' or names; 'choose: none' serves free "
              "durations, free parameters and linear controls");
    return std::nullopt;
  }
  choice.system =
      initial_choice(system, choice.coordinates, controls, durations_in_state(system, controls));
  choice.remembered = cycle || durations || first_controls;
  return choice;
}

}  // namespace

BuiltInitialChoice build_initial_choice(const ProblemSpec& spec, const Plant& plant,
                                        const std::vector<double>& state, bool previous,
                                        Diagnostics& out) {
  const CostSpec* cycle = spec.first_use(&ResidualNeeds::chosen_start);
  if (!check_free_durations(spec, *plant.system, out)) return {.valid = false, .choice = {}};
  if (!spec.phases.front().choice) return {.valid = check_given_start(cycle, out), .choice = {}};
  auto choice = make_choice(spec, plant, state, previous, cycle != nullptr, out);
  const bool valid = choice.has_value();
  return {.valid = valid, .choice = std::move(choice)};
}

}  // namespace conddp
