#include <algorithm>

#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "problem_file/residuals/cost_residual.hpp"
#include "problem_file/residuals/key_kinds.hpp"
#include "problem_file/residuals/reference_form.hpp"
#include "problem_file/residuals/residual_table.hpp"

namespace conddp {
namespace {

/// Whether a state index is a coordinate on its own: in a flat part, or of the position of a pose.
bool is_coordinate(const StateManifold& manifold, int index) {
  using Part = StateManifold::Part;
  for (const auto& segment : manifold.segments()) {
    const int count = segment.part == Part::flat ? segment.n : segment.part == Part::se3 ? 3 : 0;
    if (index >= segment.x && index < segment.x + count) return true;
  }
  return false;
}

/// Position and velocity limits of a robot in the order of tangent vectors.
void set_state_limits(const MultibodySystem& system, CostResidual& result) {
  result.lower.assign(system.ndx(), -kUnlimited);
  result.upper.assign(system.ndx(), kUnlimited);
  for (int joint = 0; joint < system.robot().joint_count(); ++joint) {
    if (!is_independent(system.robot(), joint)) continue;
    const MultibodySystem::JointLimits limits = system.limits(joint);
    const int row = *system.velocity_row(joint);
    result.lower[row] = limits.lower;
    result.upper[row] = limits.upper;
    result.lower[system.nv() + row] = -limits.max_velocity;
    result.upper[system.nv() + row] = limits.max_velocity;
  }
}

/// Of the columns that can be chosen those that a name means, several where it has a `*`; none is
/// reported.
std::vector<std::string> find_columns(const std::vector<std::string>& all,
                                      const std::vector<std::string>& free, const Name& name,
                                      Diagnostics& out) {
  std::vector<std::string> found;
  std::copy_if(free.begin(), free.end(), std::back_inserter(found),
               [&](const std::string& column) { return fits(name.value, column); });
  if (!found.empty()) return found;
  const bool rotation = std::any_of(
      all.begin(), all.end(), [&](const std::string& column) { return fits(name.value, column); });
  out.error(name.place,
            rotation
                ? fmt::format("'{}' is part of a rotation and cannot be chosen alone", name.value)
                : fmt::format("the state has no column '{}'", name.value),
            name_hint(name.value, free, "columns that can be chosen"));
  return found;
}

/// The columns of the state that are coordinates on their own.
std::vector<std::string> free_columns(const System& system) {
  const std::vector<std::string> all = state_names(system).names;
  std::vector<std::string> free;
  for (int i = 0; i < system.nx(); ++i)
    if (is_coordinate(system.manifold(), i)) free.push_back(all[i]);
  return free;
}

std::optional<CostResidual> make_of_columns(const std::vector<Name>& names, const System& system,
                                            Diagnostics& out) {
  CostResidual result;
  const ComponentNames all = state_names(system);
  const std::vector<std::string> free = free_columns(system);
  for (const Name& name : names) {
    const auto found = find_columns(all.names, free, name, out);
    if (found.empty()) return std::nullopt;
    for (const std::string& column : found) {
      if (std::find(result.columns.begin(), result.columns.end(), column) != result.columns.end())
        continue;
      result.columns.push_back(column);
      const auto at = std::find(all.names.begin(), all.names.end(), column);
      result.indices.push_back(static_cast<int>(at - all.names.begin()));
    }
  }
  result.rows = result.references = {"chosen columns", result.columns};
  result.residual = coordinate_residual(system.manifold(), result.indices);
  result.parameters = StateManifold::flat(static_cast<int>(result.indices.size()));
  result.in_state = [indices = result.indices](const std::vector<double>& x) {
    std::vector<double> values;
    for (const int i : indices) values.push_back(x[i]);
    return values;
  };
  return result;
}

std::optional<CostResidual> make_state(const ResidualContext& context) {
  const System& system = *context.plant.system;
  if (const auto* columns = context.cost.keys.find(key::columns))
    return make_of_columns(*columns, system, context.out);
  CostResidual result;
  result.residual = state_residual(system.manifold());
  result.rows = tangent_names(system);
  result.references = state_names(system);
  result.parameters = system.manifold();
  result.columns = result.references.names;
  result.in_state = [](const std::vector<double>& x) { return x; };
  if (context.plant.multibody()) set_state_limits(*context.plant.multibody(), result);
  return result;
}

}  // namespace

std::span<const ResidualDefinition> state_residuals() {
  static const ResidualKey columns = names_key(
      key::columns, "Of the residual 'state': chosen columns instead of all; names may have a *");
  static const ResidualDefinition all[] = {
      {.name = "state",
       .description = "the state minus a reference, or the chosen columns of it",
       .unit = "that of the columns",
       .synonyms = {"x", "posture"},
       .keys = {&columns},
       .reference = &kStateReference,
       .has_limits = true,
       .is_point = [](const CostSpec& cost) { return cost.keys.find(key::columns) != nullptr; },
       .of_positions = true,
       .make = make_state}};
  return all;
}

}  // namespace conddp
