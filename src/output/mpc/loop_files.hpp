#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "output/mpc/loop_task.hpp"
#include "output/solution/contact_forces.hpp"

namespace conddp {

class AtomicFiles;

/// The value of `format` in an mpc.json, and the names of the files of a closed loop.
inline constexpr std::string_view kMpcFormat = "conddp.mpc/1";
inline constexpr const char* kLoopFile = "mpc.json";
inline constexpr const char* kPlantFile = "closed_loop.csv";
inline constexpr const char* kTicksFile = "ticks.csv";
inline constexpr const char* kTickTimesFile = "tick_times.csv";

/// Data for the files of a closed loop.
struct LoopRun {
  const LoopTask& task;
  const ClosedLoopResult& result;
  std::vector<std::string> overrides;  ///< command-line settings, as given
};

/// A time for tables, without the trailing digits of sums of decimal numbers.
double tabulated_time(double time);

/// The first line of closed_loop.csv, without its line end.
std::string closed_loop_header(const LoopTask& task);

/// closed_loop.csv: t, phase, states, controls and contact forces of the plant. One row per step,
/// and one for the last state, without controls and forces. Cells of open contacts are empty.
std::string closed_loop_csv(const LoopRun& run);

/// ticks.csv: one row per tick. Cells are empty for non-finite numbers and for ticks without a
/// solve.
std::string ticks_csv(const LoopRun& run);

/// tick_times.csv: wall-clock times of preparation and feedback, one row per tick. With a simulated
/// clock, this is the only file of a closed loop that differs between two runs.
std::string tick_times_csv(const LoopRun& run);

/// mpc.json: description and outcome of the simulation (schemas/mpc.schema.json).
OrderedJson loop_json(const LoopRun& run);

/// Adds the four files, in a folder, to a set that appears atomically. Returns their paths.
std::vector<std::filesystem::path> add_loop(const LoopRun& run, const std::filesystem::path& folder,
                                            AtomicFiles& files);

/// Writes the four files into a folder, which is created if needed. On an OutputError, no file is
/// written. Returns their paths.
std::vector<std::filesystem::path> write_loop(const LoopRun& run,
                                              const std::filesystem::path& folder);

/// The contacts of a loop's file with `rows` empty rows of forces. Torques of surface contacts are
/// omitted: a contact-implicit plant has forces at points.
ContactForces no_plant_forces(const LoopTask& task, int rows);

/// Contact forces of a loop's plant, one row per step. A contact-implicit plant has its own;
/// otherwise they are those of the scheduled contacts, at the beginning of the step.
ContactForces plant_forces(const LoopTask& task, const ClosedLoopResult& result);

}  // namespace conddp
