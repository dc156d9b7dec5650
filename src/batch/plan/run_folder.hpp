#pragma once

#include <filesystem>

#include "batch/plan/batch_plan.hpp"
#include "batch/plan/manifest.hpp"

namespace conddp {

/// Writes the manifest of a run, and the plan beside it for whoever reads it later. A folder that
/// has the same manifest stays as it is, and one with results of the same plan may be divided into
/// another number of shards. Reported as errors are results of another plan or build, and a
/// plan.yaml of the user. Throws OutputError where the files cannot be written.
void write_run_folder(const BatchPlan& plan, const Manifest& manifest,
                      const std::filesystem::path& run, Diagnostics& out);

/// Whether a problem of a run is what it was when the plan was made, with the files that it reads.
/// Else reports why not.
bool is_as_planned(const Manifest& manifest, int problem, const std::filesystem::path& run,
                   Diagnostics& out);

/// Whether the problems of a run are what they were when its plan was made, with the files that
/// they and its items read, and this build is the one that made it or `any_build` is true. Else
/// reports why not.
bool fits_run_folder(const Manifest& manifest, const std::filesystem::path& run, bool any_build,
                     Diagnostics& out);

/// Warns where an item may take for ever: the plan has no limit of time, nor has a problem file.
void warn_without_time_limit(const Manifest& manifest, const std::filesystem::path& run,
                             Diagnostics& out);

/// A file of a run, as seen from here.
std::filesystem::path file_of_run(const ManifestFile& file, const std::filesystem::path& run);

/// A problem file of a run, as seen from here.
std::filesystem::path problem_of_run(const Manifest& manifest, int problem,
                                     const std::filesystem::path& run);

}  // namespace conddp
