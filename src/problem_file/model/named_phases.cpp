#include "problem_file/model/named_phases.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "problem_file/model/components.hpp"

namespace conddp {
std::vector<bool> phases_named(const std::optional<std::vector<Name>>& names,
                               const ProblemSpec& spec) {
  std::vector<bool> named(spec.phases.size(), !names.has_value());
  if (!names) return named;
  for (std::size_t p = 0; p < named.size(); ++p)
    named[p] = std::any_of(names->begin(), names->end(), [&](const Name& name) {
      return fits(name.value, spec.phases[p].name.value);
    });
  return named;
}

std::vector<bool> phases_named(const std::optional<std::vector<Name>>& names,
                               const ProblemSpec& spec, Diagnostics& out) {
  std::vector<std::string> known;
  for (const PhaseSpec& phase : spec.phases) known.push_back(phase.name.value);
  if (names)
    for (const Name& name : *names)
      if (std::none_of(known.begin(), known.end(),
                       [&](const std::string& phase) { return fits(name.value, phase); }))
        out.error(name.place, fmt::format("unknown phase '{}'", name.value),
                  name_hint(name.value, known, "phases"));
  return phases_named(names, spec);
}

bool names_phase(const CostSpec& function, std::size_t phase, const ProblemSpec& spec) {
  if (function.phases || !function.knots) return function.phases.has_value();
  int first = 0;
  for (std::size_t i = 0; i < phase; ++i) first += spec.phases[i].knots.value;
  const int end = first + spec.phases[phase].knots.value;
  return std::any_of(function.knots->begin(), function.knots->end(),
                     [&](const KnotSpec& knot) { return knot.value >= first && knot.value < end; });
}

std::vector<bool> possible_phases(const CostSpec& function, const ProblemSpec& spec) {
  std::vector<bool> possible = phases_named(function.phases, spec);
  for (std::size_t p = 0; p < possible.size(); ++p) {
    const PhaseSpec& phase = spec.phases[p];
    const bool by_default = !phase.takes_no_time() && !function.knots;
    if (phase.choice || (!by_default && !names_phase(function, p, spec))) possible[p] = false;
  }
  return possible;
}

void check_weights(const ProblemSpec& spec, Diagnostics& out) {
  std::vector<std::string> names;
  for (const CostSpec& cost : spec.costs) names.push_back(cost.name.value);
  for (const PhaseSpec& phase : spec.phases)
    for (const auto& [name, value] : phase.weights)
      if (std::find(names.begin(), names.end(), name.value) == names.end())
        out.error(name.place, fmt::format("unknown cost '{}'", name.value),
                  name_hint(name.value, names, "costs"));
}

}  // namespace conddp
