#include "problem_file/build/initial_choice.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "problem_file/spec/components.hpp"
#include "problem_file/spec/phase_grid.hpp"

namespace conddp {
namespace {

/// What a free duration cannot go together with, at the place that says so.
bool check_free_durations(const ProblemSpec& spec, const System& system, Diagnostics& out) {
  const PhaseSpec* free = spec.first_free_duration();
  if (free == nullptr) return true;
  const int errors = out.error_count();
  const Place& place = free->free_duration->place;
  if (!spec.phases.front().choice)
    out.error(place, "durations are chosen in a first phase without time, and there is none",
              "write '- {choose: none}' as the first of the phases");
  if (spec.stepping)
    out.error(place, "steps that find their contacts have no free duration");
  else if (system.kind() == SystemKind::discrete)
    out.error(place, "a system that gives the next state itself knows no time");
  for (const auto* list : {&spec.costs, &spec.terminal_costs})
    for (const CostSpec& cost : *list)
      if (cost.keys.find(key::swing) != nullptr)
        out.error(cost.name.place, "a swing is a motion over time, and durations are free");
  for (const auto* list : {&spec.constraints, &spec.terminal_constraints})
    for (const ConstraintSpec& constraint : *list)
      if (constraint.softness != Softness::hard)
        out.error(constraint.function.name.place,
                  "soft constraints and free durations exclude each other");
  return out.error_count() == errors;
}

/// The durations that are free, as further controls of the choice.
void add_durations(const ProblemSpec& spec, InitialChoice& choice, std::vector<Column>& controls) {
  for (const PhaseSpec& phase : spec.phases) {
    auto& free = choice.durations.emplace_back();
    if (!phase.free_duration) continue;
    free = {.memory = static_cast<int>(controls.size()),
            .written = phase_duration(phase),
            .scales_cost = spec.running_costs == RunningCosts::kRate};
    choice.lower.push_back(phase.free_duration->lower);
    choice.upper.push_back(phase.free_duration->upper);
    controls.push_back({"duration/" + phase.name.value, "s"});
  }
}

}  // namespace

BuiltInitialChoice build_initial_choice(const ProblemSpec& spec, const Plant& plant,
                                        const std::vector<double>& state, bool control_memory,
                                        Diagnostics& out) {
  const CostSpec* cycle = spec.first_use(&ResidualNeeds::chosen_start);
  const PhaseSpec& phase = spec.phases.front();
  if (!check_free_durations(spec, *plant.system, out)) return {.valid = false, .choice = {}};
  if (!phase.choice) {
    if (cycle == nullptr) return {};
    out.error(cycle->residual.place,
              fmt::format("the residual '{}' measures from a first state that is chosen, and it is "
                          "given",
                          cycle->residual.value),
              "write '- {choose: all}' as the first of the phases");
    return {.valid = false, .choice = {}};
  }
  if (control_memory) {
    out.error(phase.knots.place,
              "'control_rate' and the choice of the initial state exclude each other");
    return {.valid = false, .choice = {}};
  }
  const ComponentNames names = tangent_names(*plant.system);
  const auto chosen = resolve(phase.choice->coordinates, names, 0.0, out);
  const auto bound = [&](const std::optional<ComponentsSpec>& given, double none) {
    return given ? resolve(*given, names, none, out)
                 : std::optional(std::vector<double>(names.size(), none));
  };
  const auto lower = bound(phase.choice->lower, -kUnlimited);
  const auto upper = bound(phase.choice->upper, kUnlimited);
  if (!chosen || !lower || !upper) return {.valid = false, .choice = {}};
  InitialChoice choice{.system = nullptr, .state = state};
  std::vector<Column> controls;
  for (int i = 0; i < names.size(); ++i) {
    if ((*chosen)[i] == 0) continue;
    if ((*lower)[i] > (*upper)[i]) {
      out.error(phase.knots.place,
                fmt::format("for '{}' the lower bound {} lies above the upper bound {}",
                            names.names[i], (*lower)[i], (*upper)[i]));
      return {.valid = false, .choice = {}};
    }
    choice.coordinates.push_back(i);
    choice.lower.push_back((*lower)[i]);
    choice.upper.push_back((*upper)[i]);
    controls.push_back({names.names[i], ""});
  }
  add_durations(spec, choice, controls);
  if (controls.empty()) {
    out.error(phase.knots.place, "no component of the state is chosen",
              "write 'choose: all', or their names");
    return {.valid = false, .choice = {}};
  }
  const bool durations = controls.size() > choice.coordinates.size();
  choice.system = initial_choice(*plant.system, choice.coordinates, controls);
  choice.remembered = cycle != nullptr || durations;
  return {.valid = true, .choice = std::move(choice)};
}

}  // namespace conddp
