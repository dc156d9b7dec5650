#pragma once

#include "batch/run/solve_item.hpp"

namespace conddp {

/// Builds the closed loop of one item and simulates it, with one thread. How the loop ended is the
/// status; a loop that takes longer than the limit of time ends at its next tick.
SolvedItem simulate_item(const ManifestItem& item, const Manifest& manifest,
                         const ProblemFamily& family);

}  // namespace conddp
