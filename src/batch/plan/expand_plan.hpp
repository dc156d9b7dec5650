#pragma once

#include <filesystem>
#include <optional>

#include "batch/plan/batch_plan.hpp"
#include "batch/plan/manifest.hpp"

namespace conddp {

/// Expands a plan into all items for a run in a folder: by problem, then by rows of the axes (the
/// first axis changes slowest), then by solver. Builds every item. If one fails, reports the errors
/// of the first one at the place of its values, with the parts of the item, and returns nothing.
std::optional<Manifest> expand_plan(const BatchPlan& plan, const std::filesystem::path& run,
                                    Diagnostics& out);

}  // namespace conddp
