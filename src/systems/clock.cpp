#include "systems/clock.hpp"

#include <algorithm>

namespace conddp {

namespace {

/// Which columns of the state are the clock or its velocity.
std::vector<bool> clock_columns(const System& system) {
  const std::vector<Column>& columns = system.state_columns();
  std::vector<bool> is_clock(columns.size(), false);
  const bool has_clock = std::any_of(columns.begin(), columns.end(),
                                     [](const Column& column) { return column.name == kClock; });
  for (std::size_t i = 0; has_clock && i < columns.size(); ++i)
    is_clock[i] = columns[i].name == kClock || columns[i].name == kClockRate;
  return is_clock;
}

}  // namespace

std::vector<int> states_without_clock(const System& system) {
  const std::vector<bool> is_clock = clock_columns(system);
  std::vector<int> states;
  for (int i = 0; i < system.nx(); ++i)
    if (!is_clock[i]) states.push_back(i);
  return states;
}

std::vector<int> clock_coordinates(const System& system) {
  const std::vector<bool> is_clock = clock_columns(system);
  std::vector<int> coordinates;
  for (const auto& segment : system.manifold().segments())
    for (int i = 0; segment.part == StateManifold::Part::flat && i < segment.n; ++i)
      if (is_clock[segment.x + i]) coordinates.push_back(segment.dx + i);
  return coordinates;
}

}  // namespace conddp
