#include "problem_file/initial_choice.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "problem_file/components.hpp"

namespace conddp {
namespace {

/// The first cost or constraint that needs the first state, null if there is none.
const CostSpec* first_cycle(const ProblemSpec& spec) {
  for (const auto* list : {&spec.costs, &spec.terminal_costs})
    for (const CostSpec& cost : *list)
      if (cost.kind == ResidualKind::kCycle) return &cost;
  for (const auto* list : {&spec.constraints, &spec.terminal_constraints})
    for (const ConstraintSpec& constraint : *list)
      if (constraint.function.kind == ResidualKind::kCycle) return &constraint.function;
  return nullptr;
}

}  // namespace

BuiltInitialChoice build_initial_choice(const ProblemSpec& spec, const Plant& plant,
                                        const std::vector<double>& state, bool control_memory,
                                        Diagnostics& out) {
  const CostSpec* cycle = first_cycle(spec);
  const PhaseSpec& phase = spec.phases.front();
  if (!phase.choice) {
    if (cycle == nullptr) return {};
    out.error(cycle->residual.place,
              "the residual 'cycle' measures from a first state that is chosen, and it is given",
              "write '- {choose: all}' as the first of the phases");
    return {.valid = false, .choice = {}};
  }
  if (control_memory) {
    out.error(phase.knots.place,
              "costs on 'control_rate' and the choice of the initial state exclude each other");
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
  std::vector<std::string> chosen_names;
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
    chosen_names.push_back(names.names[i]);
  }
  if (chosen_names.empty()) {
    out.error(phase.knots.place, "no component of the state is chosen",
              "write 'choose: all', or their names");
    return {.valid = false, .choice = {}};
  }
  choice.system = initial_choice(*plant.system, choice.coordinates, chosen_names);
  choice.remembered = cycle != nullptr;
  return {.valid = true, .choice = std::move(choice)};
}

}  // namespace conddp
