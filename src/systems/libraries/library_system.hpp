#pragma once

#include <memory>
#include <vector>

#include "systems/libraries/library_knot_function.hpp"
#include "systems/system.hpp"

namespace conddp {

/// Columns of a system whose rate, acceleration or next state is a compiled function.
struct LibrarySystemColumns {
  SystemKind kind = SystemKind::first_order;
  std::vector<Column> states;      ///< or positions
  std::vector<Column> velocities;  ///< of a second-order system, one for each position
  std::vector<Column> controls;
};

/// A system defined by a compiled function whose x is the state; for a second-order system,
/// positions and velocities. If the function reads the time, the state includes the clock, as in a
/// system of expressions. The clock follows the states or positions, and its rate follows the
/// velocities. The function must have a row for each state or velocity and the sizes of the
/// columns; a discrete one must not read the time.
std::shared_ptr<const System> make_library_system(
    const LibrarySystemColumns& columns, std::shared_ptr<const LibraryKnotFunction> function);

/// A default initial state: zero, with a running clock.
std::vector<double> usual_library_state(const System& system);

}  // namespace conddp
