#include <algorithm>

#include "problem_file/residuals/cost_residual.hpp"
#include "problem_file/residuals/residual_keys.hpp"
#include "problem_file/residuals/residual_table.hpp"
#include "systems/system.hpp"

namespace conddp {
namespace {

/// Offset on the columns of the initial state.
const Key<ComponentsSpec> kOffset{"offset", ComponentsSpec{.scalar = 0.0}};

/// Offset for each number of the state; rotations do not support offsets.
std::optional<std::vector<double>> cycle_offset(const ResidualContext& context) {
  const System& system = *context.plant.system;
  const ComponentsSpec* given = context.cost.keys.find(kOffset);
  if (given == nullptr) return std::vector<double>(system.nx(), 0.0);
  auto offset = resolve(*given, state_names(system), 0.0, context.out);
  if (!offset) return std::nullopt;
  for (const auto& segment : system.manifold().curved()) {
    const int first = segment.x + (segment.part == StateManifold::Part::se3 ? 3 : 0);
    for (int i = first; i < first + 4; ++i) {
      if ((*offset)[i] == 0) continue;
      context.out.error(given->place, "an offset cannot be added to a rotation",
                        "positions, joints and velocities can have one");
      return std::nullopt;
    }
  }
  return offset;
}

/// Coordinates that are not periodic: the clock, and coordinates at rest at the end or at the
/// beginning.
std::vector<int> coordinates_apart(const Plant& plant) {
  std::vector<int> apart = other_coordinates(*plant.system);
  if (!plant.variants.empty())
    for (const int i : other_coordinates(*plant.variants[plant.variant_at.front()].system))
      if (std::ranges::find(apart, i) == apart.end()) apart.push_back(i);
  std::ranges::sort(apart);
  return apart;
}

std::optional<CostResidual> make_cycle(const ResidualContext& context) {
  const auto offset = cycle_offset(context);
  if (!offset) return std::nullopt;
  const System& system = *context.plant.system;
  CostResidual result;
  const std::vector<int> apart = coordinates_apart(context.plant);
  std::vector<std::string> rows;
  const std::vector<std::string> names = tangent_names(system).names;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (std::ranges::find(apart, static_cast<int>(i)) == apart.end()) rows.push_back(names[i]);
  const bool remembers = !context.spec.has_linear_controls() &&
                         context.spec.first_use(&ResidualNeeds::previous_control) != nullptr;
  if (remembers)
    for (const std::string& control : control_names(context.plant).names)
      rows.push_back("previous/" + control);
  result.residual = cycle_residual(system.manifold(), *context.plant.start, *offset, apart,
                                   remembers ? context.plant.actuated().nu() : 0, context.ndx);
  result.rows = {"components of the state", std::move(rows)};
  return result;
}

}  // namespace

std::span<const ResidualDefinition> cycle_residuals() {
  static const ResidualKey offset = residual_key(
      kOffset,
      {.says = "For cycle: offset of columns of the first state (not of rotations); 0 by default",
       .examples = R"([{"q/base_x": 0.3}])",
       .fallback = "none"},
      ComponentsForm{});
  static const ResidualDefinition all[] = {
      {.name = "cycle",
       .description =
           "the state minus the free initial state of a phase 'choose', and minus an offset",
       .unit = "same as the state",
       .synonyms = {"periodic", "periodicity"},
       .needs = {.chosen_start = true},
       .keys = {&offset},
       .make = make_cycle}};
  return all;
}

}  // namespace conddp
