#include "problem_file/lower/start.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "problem_file/lower/grid.hpp"

namespace conddp {
namespace {

/// Place of the first key that needs a choice of the start; null if there is none.
const Place* needs_choice(const ProblemSpec& spec) {
  if (const PhaseSpec* phase = spec.first_free_duration()) return &phase->free_duration->place;
  if (!spec.names.free.empty()) return &spec.names.free.front().name.place;
  const bool given = spec.initial_state.previous_control.has_value();
  return spec.has_linear_controls() && !given ? &spec.controls.place : nullptr;
}

/// `start`, or a name like it that no phase has.
std::string free_name(const std::vector<PhaseSpec>& phases) {
  std::string name = "start";
  const auto is_taken = [&](const PhaseSpec& phase) { return phase.name.value == name; };
  while (std::ranges::any_of(phases, is_taken)) name += '_';
  return name;
}

PhaseSpec empty_choice(const ProblemSpec& spec, const Place& place) {
  PhaseSpec phase{.name = {free_name(spec.phases), place}, .knots = {1, place}};
  phase.choice.emplace().coordinates.form = ComponentsSpec::Form::kMap;
  if (!spec.phases.front().restitution) phase.contacts = spec.phases.front().contacts;
  return phase;
}

/// Names the components of values given by a single number. False for a list.
bool name_components(ComponentsSpec& values) {
  if (values.form == ComponentsSpec::Form::kList) return false;
  if (values.form == ComponentsSpec::Form::kScalar && values.scalar)
    values.map = {{{"*", values.place}, values.scalar}};
  values.form = ComponentsSpec::Form::kMap;
  return true;
}

/// Bounds the displacement of a parameter from its start.
void bound(const FreeParameter& parameter, double value, std::optional<ComponentsSpec>& bounds,
           Diagnostics& out) {
  if (!bounds) bounds = ComponentsSpec{parameter.name.place};
  if (!name_components(*bounds))
    return out.error(bounds->place, "beside free parameters these bounds are given by name",
                     "write '{x: -1, ...}'");
  for (const auto& [name, given] : bounds->map)
    if (name.value == parameter.name.value)
      return out.error(name.place, fmt::format("'{}' is free, and stands here again", name.value),
                       "its values are 'start', 'lower' and 'upper' below 'parameters'");
  bounds->map.emplace_back(parameter.name, value);
}

void choose(const FreeParameter& parameter, ChoiceSpec& choice, Diagnostics& out) {
  auto& coordinates = choice.coordinates.map;
  name_components(choice.coordinates);
  if (std::ranges::none_of(coordinates, [&](const auto& entry) {
        return entry.first.value == parameter.name.value;
      }))
    coordinates.emplace_back(parameter.name, 1.0);
  bound(parameter, parameter.lower - parameter.start, choice.lower, out);
  bound(parameter, parameter.upper - parameter.start, choice.upper, out);
}

}  // namespace

void choose_start(ProblemSpec& spec, Diagnostics& out) {
  const Place* place = needs_choice(spec);
  if (place == nullptr) return;
  if (!spec.phases.front().choice) {
    spec.phases.insert(spec.phases.begin(), empty_choice(spec, *place));
    renumber(spec, [](int node) { return node + 1; });
  }
  for (const FreeParameter& parameter : spec.names.free)
    choose(parameter, *spec.phases.front().choice, out);
}

}  // namespace conddp
