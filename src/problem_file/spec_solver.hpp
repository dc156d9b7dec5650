#pragma once

#include "problem_file/diagnostic.hpp"
#include "solvers/options.hpp"

namespace conddp {

/// The solver and its options.
struct SolverSpec {
  Name name{"auto", {}};
  SolverOptions options;
};

}  // namespace conddp
