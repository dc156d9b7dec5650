#include "systems/system.hpp"

namespace conddp {
namespace {

/// True for the system's own state columns: neither by_name_only nor at rest.
std::vector<bool> own_columns(const System& system) {
  const std::vector<Column>& columns = system.state_columns();
  const int named = static_cast<int>(columns.size());
  std::vector<bool> own;
  for (int i = 0; i < system.nx(); ++i)
    own.push_back(i >= named || (system.has_state(i) && !columns[i].by_name_only));
  return own;
}

/// Names a component of a rotation after the matching quaternion component.
Column rotation_column(Column column) {
  const std::size_t q = column.name.rfind('q');  // ".../qx"
  if (q != std::string::npos) column.name[q] = 'r';
  column.unit = "rad";
  return column;
}

}  // namespace

std::vector<Column> tangent_columns(const System& system) {
  std::vector<Column> tangent(system.ndx());
  const std::vector<Column>& columns = system.state_columns();
  for (const auto& segment : system.manifold().segments()) {
    using Part = StateManifold::Part;
    // A flat segment contains numbers only; a pose has three of them before its rotation.
    const int flat = segment.part == Part::flat ? segment.n : segment.part == Part::se3 ? 3 : 0;
    for (int i = 0; i < flat; ++i) tangent[segment.dx + i] = columns[segment.x + i];
    for (int i = flat; i < segment.n; ++i)
      tangent[segment.dx + i] = rotation_column(columns[segment.x + i]);
  }
  return tangent;
}

std::vector<int> own_states(const System& system) {
  const std::vector<bool> own = own_columns(system);
  std::vector<int> states;
  for (int i = 0; i < system.nx(); ++i)
    if (own[i]) states.push_back(i);
  return states;
}

std::vector<int> other_coordinates(const System& system) {
  const std::vector<bool> own = own_columns(system);
  std::vector<int> coordinates;
  for (const auto& segment : system.manifold().segments()) {
    // A rotation or a pose is either the system's own or not, as a whole.
    const bool flat = segment.part == StateManifold::Part::flat;
    for (int i = 0; i < segment.n; ++i)
      if (!own[segment.x + (flat ? i : 0)]) coordinates.push_back(segment.dx + i);
  }
  return coordinates;
}

}  // namespace conddp
