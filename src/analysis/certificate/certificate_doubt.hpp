#pragma once

#include "solvers/strategies/registry.hpp"

namespace conddp {

/// What the certificate of an answer denies that was solved with these options.
Doubt certificate_doubt(const SolverOptions& options);

}  // namespace conddp
