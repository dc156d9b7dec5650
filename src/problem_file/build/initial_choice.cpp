#include "problem_file/build/initial_choice.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "problem_file/spec/components.hpp"
#include "problem_file/spec/phase_grid.hpp"

namespace conddp {
namespace {

void check_terms_of_free_durations(const ProblemSpec& spec, Diagnostics& out) {
  for (const CostSpec* cost : spec.all_costs())
    if (cost->keys.find(key::swing) != nullptr)
      out.error(cost->name.place, "swings do not support free durations",
                "write where the foot is at some knots: '{residual: frame_position, knots: [10], "
                "...}' as constraints or costs");
  for (const ConstraintSpec* constraint : spec.all_constraints())
    if (constraint->softness != Softness::hard)
      out.error(constraint->function.name.place, "soft constraints do not support free durations",
                constraint->softness == Softness::l2
                    ? "write it as a cost with 'activation: {kind: quadratic_barrier, ...}'"
                    : "write it as a cost on 'residual: expression' with 'activation: linear' and "
                      "rows: smooth_max(violation, 0, width)");
}

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
    out.error(place, "contact-implicit problems do not support free durations");
  else if (system.kind() == SystemKind::discrete)
    out.error(place, "difference equations have no time, so durations are not free");
  check_terms_of_free_durations(spec, out);
  return out.error_count() == errors;
}

/// The durations that are free, as further controls of the choice.
void add_durations(const ProblemSpec& spec, InitialChoice& choice, std::vector<Column>& controls) {
  for (const PhaseSpec& phase : spec.phases) {
    auto& free = choice.durations.emplace_back();
    if (!phase.free_duration) continue;
    free = {.choice = static_cast<int>(controls.size()),
            .written = phase_duration(phase),
            .scales_cost = spec.running_costs == RunningCosts::kRate};
    choice.lower.push_back(phase.free_duration->lower);
    choice.upper.push_back(phase.free_duration->upper);
    controls.push_back({"duration/" + phase.name.value, "s"});
  }
}

/// Whether the file can do with a given initial state; else that is reported.
bool check_given_start(const CostSpec* cycle, Diagnostics& out) {
  if (cycle == nullptr) return true;
  out.error(
      cycle->residual.place,
      fmt::format("the residual '{}' measures from a first state that is chosen, and it is "
                  "given",
                  cycle->residual.value),
      "write '- {choose: all}' as the first of the phases; 'conddp check --expand' writes out "
      "those of a gait");
  return false;
}

/// The coordinates that the first phase chooses within their bounds, and the names of these
/// controls. False, with an error, where bounds do not fit.
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

/// The first of linear controls. Their bounds are those of the knots.
void add_first_controls(const System& actuated, InitialChoice& choice,
                        std::vector<Column>& controls) {
  choice.first_controls = actuated.nu();
  controls.insert(controls.end(), actuated.control_columns().begin(),
                  actuated.control_columns().end());
  choice.lower.resize(controls.size(), -kUnlimited);
  choice.upper.resize(controls.size(), kUnlimited);
}

/// The choice of the first phase, if it can be.
std::optional<InitialChoice> make_choice(const ProblemSpec& spec, const Plant& plant,
                                         const std::vector<double>& state, bool cycle,
                                         Diagnostics& out) {
  const PhaseSpec& phase = spec.phases.front();
  const System& system = *plant.system;
  InitialChoice choice{.system = nullptr, .state = state};
  std::vector<Column> controls;
  if (!add_coordinates(phase, tangent_names(system), choice, controls, out)) return std::nullopt;
  add_durations(spec, choice, controls);
  const bool durations = controls.size() > choice.coordinates.size();
  if (spec.has_linear_controls()) add_first_controls(plant.actuated(), choice, controls);
  if (controls.empty()) {
    out.error(phase.knots.place, "no component of the state is chosen",
              "leave the phase out, or write 'choose: all' or names; 'choose: none' serves free "
              "durations, free parameters and linear controls");
    return std::nullopt;
  }
  choice.system = initial_choice(system, choice.coordinates, controls);
  choice.remembered = cycle || durations || spec.has_linear_controls();
  return choice;
}

}  // namespace

BuiltInitialChoice build_initial_choice(const ProblemSpec& spec, const Plant& plant,
                                        const std::vector<double>& state, ControlMemory memory,
                                        Diagnostics& out) {
  const CostSpec* cycle = spec.first_use(&ResidualNeeds::chosen_start);
  const PhaseSpec& phase = spec.phases.front();
  if (!check_free_durations(spec, *plant.system, out)) return {.valid = false, .choice = {}};
  if (!phase.choice) return {.valid = check_given_start(cycle, out), .choice = {}};
  auto choice = make_choice(spec, plant, state, cycle != nullptr, out);
  bool valid = choice.has_value();
  if (valid && choice->remembered && memory == ControlMemory::previous) {
    out.error(phase.knots.place,
              fmt::format("'{}' does not support {}", spec.use_of_previous_control(),
                          cycle != nullptr ? "periodic motions" : "free durations"),
              "let the control be a state, and its rate the control");
    valid = false;
  }
  return {.valid = valid, .choice = std::move(choice)};
}

}  // namespace conddp
