#pragma once

#include "problem_file/diagnostic.hpp"
#include "solvers/options.hpp"

namespace conddp {

/// A number of the file that a homotopy moves.
struct HomotopyKeySpec {
  Name key;  ///< a path as `--set` takes it
  Located<double> from, to;
};

/// The solver and its options.
struct SolverSpec {
  Name name{"auto", {}};
  SolverOptions options;
  std::vector<HomotopyKeySpec> homotopy;
};

}  // namespace conddp
