#pragma once

#include <memory>
#include <vector>

#include "systems/libraries/library_knot_function.hpp"
#include "systems/system.hpp"

namespace conddp {

/// What a compiled function is the rate, acceleration or next state of: columns of numbers.
struct LibrarySystemColumns {
  SystemKind kind = SystemKind::first_order;
  std::vector<Column> states;      ///< or positions
  std::vector<Column> velocities;  ///< of a second-order system, one for each position
  std::vector<Column> controls;
};

/// A system of a compiled function, whose x is the state, of a second-order system positions and
/// velocities. Where the function reads the time, the state gets the clock, as that of a system of
/// expressions does: behind the states or positions, with its rate behind the velocities. The
/// function has a row for each state or velocity, and the sizes of the columns; a discrete one
/// reads no time.
std::shared_ptr<const System> make_library_system(
    const LibrarySystemColumns& columns, std::shared_ptr<const LibraryKnotFunction> function);

/// A state of it to begin from: zero, with a clock that goes.
std::vector<double> usual_library_state(const System& system);

}  // namespace conddp
