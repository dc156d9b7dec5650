#pragma once

#include <filesystem>
#include <optional>

#include "batch/plan/batch_plan.hpp"
#include "batch/plan/manifest.hpp"

namespace conddp {

/// All items of a plan for a run in a folder: problems first, then the rows of the axes (the first
/// axis changes slowest), then solvers. Every item is built; errors of the first that cannot be
/// are reported where its values stand, with what makes up the item. Nothing is returned then.
std::optional<Manifest> expand_plan(const BatchPlan& plan, const std::filesystem::path& run,
                                    Diagnostics& out);

}  // namespace conddp
