#pragma once

#include <filesystem>

#include "batch/plan/batch_plan.hpp"
#include "batch/plan/manifest.hpp"

namespace conddp {

/// Writes the manifest of a run, with a copy of the plan for later readers. A folder with the same
/// manifest is left unchanged; one with results of the same plan may be divided into another number
/// of shards. Results of another plan or build, and a plan.yaml of the user, are errors. Throws
/// OutputError if the files cannot be written.
void write_run_folder(const BatchPlan& plan, const Manifest& manifest,
                      const std::filesystem::path& run, Diagnostics& out);

/// True if a problem of a run, including the files that it reads, is the same as at the time of
/// planning. Otherwise reports the reason.
bool is_as_planned(const Manifest& manifest, int problem, const std::filesystem::path& run,
                   Diagnostics& out);

/// True if the problems of a run are the same as at the time of planning, including the files that
/// they and the items read. The build must also be the same, unless `any_build` is true. Otherwise
/// reports the reason.
bool fits_run_folder(const Manifest& manifest, const std::filesystem::path& run, bool any_build,
                     Diagnostics& out);

/// Warns if an item may run indefinitely: neither the plan nor its problem file limits the time.
void warn_without_time_limit(const Manifest& manifest, const std::filesystem::path& run,
                             Diagnostics& out);

/// The path of a run's file from the working directory.
std::filesystem::path file_of_run(const ManifestFile& file, const std::filesystem::path& run);

/// The path of a run's problem file from the working directory.
std::filesystem::path problem_of_run(const Manifest& manifest, int problem,
                                     const std::filesystem::path& run);

}  // namespace conddp
