#include <algorithm>

#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "problem_file/residuals/cost_residual.hpp"
#include "problem_file/residuals/reference_form.hpp"
#include "problem_file/residuals/residual_keys.hpp"
#include "problem_file/residuals/residual_table.hpp"
#include "systems/system.hpp"

namespace conddp {
namespace {

/// A part of a state that `columns` can select: a coordinate, or an entire rotation.
struct StatePart {
  std::string name;
  std::vector<int> indices;  ///< into the state; for a rotation those of its quaternion
  int tangent;               ///< its first tangent coordinate
  bool listed = true;        ///< a name with a * may select it
  bool at_rest = false;      ///< only other phases have it

  bool is_rotation() const { return indices.size() > 1; }
};

/// "q" for the quaternion q/x, q/y, q/z, q/w; empty for other columns.
std::string name_of_rotation(const std::string& first_column) {
  return first_column.ends_with("/x") ? first_column.substr(0, first_column.size() - 2) : "";
}

std::vector<StatePart> parts_of_state(const System& system) {
  using Part = StateManifold::Part;
  const ComponentNames all = state_names(system);
  std::vector<StatePart> parts;
  for (const auto& segment : system.manifold().segments()) {
    const int flat = segment.part == Part::flat ? segment.n : segment.part == Part::se3 ? 3 : 0;
    for (int i = segment.x; i < segment.x + flat; ++i)
      parts.push_back(
          {all.names[i], {i}, segment.dx + i - segment.x, all.is_listed(i), !system.has_state(i)});
    if (segment.part == Part::flat) continue;
    const int q = segment.x + flat;
    parts.push_back({name_of_rotation(all.names[q]),
                     {q, q + 1, q + 2, q + 3},
                     segment.dx + flat,
                     all.is_listed(q),
                     !system.has_state(q)});
  }
  return parts;
}

/// Position and velocity limits of a robot in the order of tangent vectors, for listed components.
void set_state_limits(const MultibodySystem& system, CostResidual& result) {
  std::vector<double> lower(system.ndx(), -kUnlimited), upper(system.ndx(), kUnlimited);
  for (int joint = 0; joint < system.robot().joint_count(); ++joint) {
    if (!is_independent(system.robot(), joint)) continue;
    const MultibodySystem::JointLimits limits = system.limits(joint);
    const int row = *system.velocity_row(joint);
    lower[row] = limits.lower;
    upper[row] = limits.upper;
    lower[system.nv() + row] = -limits.max_velocity;
    upper[system.nv() + row] = limits.max_velocity;
  }
  const ComponentNames names = tangent_names(system);
  for (int i = 0; i < system.ndx(); ++i) {
    if (!names.is_listed(i)) continue;
    result.lower.push_back(lower[i]);
    result.upper.push_back(upper[i]);
  }
}

/// True if a name selects a part. A rotation has only its own names, "q" or "q/*".
bool is_meant_by(const std::string& name, const StatePart& part,
                 const std::vector<std::string>& columns) {
  if (part.is_rotation())
    return !part.name.empty() && (name == part.name || name == part.name + "/*");
  return part.listed ? fits(name, columns[part.indices.front()]) : name == part.name;
}

/// The parts that a name selects, several if it has a `*`. Reports a name that selects no part.
std::vector<const StatePart*> find_parts(const std::vector<std::string>& columns,
                                         const std::vector<StatePart>& parts, const Name& name,
                                         const Plant& plant, Diagnostics& out) {
  std::vector<const StatePart*> found;
  std::vector<std::string> names;
  for (const StatePart& part : parts) {
    const bool is_meant = is_meant_by(name.value, part, columns);
    if (is_meant && part.at_rest) {
      out.error(name.place, fmt::format("the system '{}' has no state '{}'", plant.name, part.name),
                "name the 'phases' whose systems have it");
      return {};
    }
    if (is_meant) found.push_back(&part);
    if (!part.name.empty() && !part.at_rest) names.push_back(part.name);
  }
  if (!found.empty()) return found;
  const bool part_of_rotation =
      std::any_of(columns.begin(), columns.end(),
                  [&](const std::string& column) { return fits(name.value, column); });
  out.error(name.place,
            part_of_rotation
                ? fmt::format("'{}' is part of a rotation and cannot be chosen alone", name.value)
                : fmt::format("the state has no column '{}'", name.value),
            name_hint(name.value, names, "columns that can be chosen"));
  return found;
}

/// The residual of selected parts of the state.
CostResidual residual_of_parts(const std::vector<const StatePart*>& chosen, const System& system) {
  const char* what = "chosen columns";
  const std::vector<std::string> columns = state_names(system).names;
  const std::vector<std::string> tangent = tangent_names(system).names;
  CostResidual result;
  std::vector<std::string> rows;
  for (const StatePart* part : chosen) {
    for (const int i : part->indices) result.columns.push_back(columns[i]);
    result.indices.insert(result.indices.end(), part->indices.begin(), part->indices.end());
    for (int row = 0; row < (part->is_rotation() ? 3 : 1); ++row)
      rows.push_back(tangent[part->tangent + row]);
    if (part->is_rotation())
      result.parameters.append(StateManifold::Part::so3);
    else
      result.parameters.append(StateManifold::Part::flat, 1);
  }
  result.rows = {what, std::move(rows)};
  result.references = {what, result.columns};
  result.residual = coordinate_residual(system.manifold(), result.indices);
  result.in_state = [indices = result.indices](const std::vector<double>& x) {
    std::vector<double> values;
    for (const int i : indices) values.push_back(x[i]);
    return values;
  };
  return result;
}

std::optional<CostResidual> make_of_columns(const std::vector<Name>& names, const Plant& plant,
                                            Diagnostics& out) {
  const System& system = *plant.system;
  const std::vector<std::string> columns = state_names(system).names;
  const std::vector<StatePart> parts = parts_of_state(system);
  std::vector<const StatePart*> chosen;
  for (const Name& name : names) {
    const auto found = find_parts(columns, parts, name, plant, out);
    if (found.empty()) return std::nullopt;
    for (const StatePart* part : found)
      if (std::find(chosen.begin(), chosen.end(), part) == chosen.end()) chosen.push_back(part);
  }
  return residual_of_parts(chosen, system);
}

/// Adds the names of states that are at rest in this system but not in that of another phase.
void name_elsewhere(const System& system, CostResidual& result) {
  const ComponentNames columns = state_names(system), tangent = tangent_names(system);
  for (int i = 0; i < columns.size(); ++i)
    if (!system.has_state(i)) result.references.elsewhere.push_back(columns.names[i]);
  for (const StatePart& part : parts_of_state(system))
    for (int row = 0; part.at_rest && row < (part.is_rotation() ? 3 : 1); ++row)
      result.rows.elsewhere.push_back(tangent.names[part.tangent + row]);
}

std::optional<CostResidual> make_state(const ResidualContext& context) {
  const System& system = *context.plant.system;
  if (const auto* columns = context.cost.keys.find(key::columns))
    return make_of_columns(*columns, context.plant, context.out);
  const std::vector<int> listed = own_states(system);
  std::vector<int> left_out;
  for (int i = 0; i < system.nx(); ++i)
    if (!std::binary_search(listed.begin(), listed.end(), i)) left_out.push_back(i);
  CostResidual result;
  result.residual = state_residual(system.manifold(), left_out);
  result.rows = tangent_names(system).listed();
  result.references = state_names(system).listed();
  result.parameters = without_coordinates(system.manifold(), left_out);
  name_elsewhere(system, result);
  result.columns = result.references.names;
  if (!left_out.empty()) result.indices = listed;
  result.in_state = [listed](const std::vector<double>& x) {
    std::vector<double> values;
    for (const int i : listed) values.push_back(x[i]);
    return values;
  };
  if (context.plant.multibody()) set_state_limits(*context.plant.multibody(), result);
  return result;
}

}  // namespace

std::span<const ResidualDefinition> state_residuals() {
  static const ResidualKey columns = residual_key(
      key::columns,
      {.says = "For the residual 'state': these columns instead of all; names may have a *"},
      NameOrNamesForm{},
      {.instead = "of others, weights and bounds by name select rows: 'weights: {\"*\": 0, u: 1}', "
                  "'upper: {u: 1}'"});
  static const ResidualDefinition all[] = {
      {.name = "state",
       .description = "the state minus a reference, or the chosen columns of it",
       .unit = "same as the columns",
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
