#pragma once

#include <memory>
#include <vector>

#include "ocp/terms/residual.hpp"
#include "systems/libraries/library_knot_function.hpp"

namespace conddp {

/// Where a knot has what a compiled function reads.
struct LibraryInputs {
  std::vector<int> states;  ///< the numbers of the state, all flat, that are its x
  int clock = -1;           ///< the number of the state that is its t; −1: a parameter is
  int ndx = 0;              ///< of the knot's model: its controls are the columns behind
};

/// The rows of a compiled function minus their references. Parameters: the references and, where
/// the function reads the time and no state is it, the time of the knot (s), whose derivative by a
/// free duration is not part of the residual. Null where it has too many numbers for a residual.
std::shared_ptr<const Residual> make_library_residual(
    std::shared_ptr<const LibraryKnotFunction> function, const LibraryInputs& inputs);

}  // namespace conddp
