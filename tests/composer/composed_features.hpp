#pragma once

#include "composed_problem.hpp"

namespace conddp {

/// Adds features to a composed problem that stand for rewritings and for numbers behind the states,
/// in any combination: free durations and parameters, integrals, linear controls, a finer grid.
ComposedProblem with_features(ComposedProblem problem, std::uint64_t seed);

}  // namespace conddp
