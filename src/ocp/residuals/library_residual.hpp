#pragma once

#include <memory>
#include <vector>

#include "ocp/terms/residual.hpp"
#include "systems/libraries/library_knot_function.hpp"

namespace conddp {

/// Mapping from a knot's state and control to a compiled function's inputs.
struct LibraryInputs {
  std::vector<int> states;  ///< state numbers, all flat, that form its x
  int clock = -1;           ///< state number that is its t; −1: t is a parameter
  int ndx = 0;              ///< of the knot's model; controls are the columns after it
};

/// Rows of a compiled function minus their references. Parameters: the references and, if the
/// function reads the time and no state provides it, the time of the knot (s). The residual omits
/// the derivative of that time by a free duration. Null if the function has too many numbers for a
/// residual.
std::shared_ptr<const Residual> make_library_residual(
    std::shared_ptr<const LibraryKnotFunction> function, const LibraryInputs& inputs);

}  // namespace conddp
