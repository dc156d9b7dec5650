#pragma once

#include "batch/run/solve_item.hpp"

namespace conddp {

/// Builds the closed loop of an item and simulates it in one thread. The status says how the loop
/// ended. A loop that exceeds the time limit ends at its next tick.
SolvedItem simulate_item(const ManifestItem& item, const Manifest& manifest,
                         const ProblemFamily& family);

}  // namespace conddp
