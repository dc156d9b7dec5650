#pragma once

#include "base/text/diagnostic.hpp"
#include "solvers/common/options.hpp"

namespace conddp {

/// A number of the file that a homotopy moves.
struct HomotopyKeySpec {
  Name key;  ///< a path as in `--set`
  Located<double> from, to;
};

/// The solver and its options.
struct SolverSpec {
  Name name{"auto", {}};
  Place place;  ///< of the section; empty if missing
  SolverOptions options;
  std::vector<HomotopyKeySpec> homotopy;
};

}  // namespace conddp
