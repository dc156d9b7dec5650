#include "systems/own_states.hpp"

#include <algorithm>

#include "systems/clock.hpp"

namespace conddp {

namespace {

/// Which columns of the state are the system's own: neither its clock, nor at rest.
std::vector<bool> own_columns(const System& system) {
  const std::vector<Column>& columns = system.state_columns();
  const bool has_clock = std::any_of(columns.begin(), columns.end(),
                                     [](const Column& column) { return column.name == kClock; });
  std::vector<bool> own;
  for (int i = 0; i < system.nx(); ++i) {
    const std::string& name = columns[i].name;
    own.push_back(system.has_state(i) && !(has_clock && (name == kClock || name == kClockRate)));
  }
  return own;
}

}  // namespace

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
    // A rotation or a pose belongs to the system as a whole.
    const bool flat = segment.part == StateManifold::Part::flat;
    for (int i = 0; i < segment.n; ++i)
      if (!own[segment.x + (flat ? i : 0)]) coordinates.push_back(segment.dx + i);
  }
  return coordinates;
}

}  // namespace conddp
