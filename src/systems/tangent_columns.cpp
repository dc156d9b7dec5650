#include "systems/tangent_columns.hpp"

namespace conddp {
namespace {

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

}  // namespace conddp
