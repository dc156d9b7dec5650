#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/json/ordered_json.hpp"
#include "output/mpc/loop_task.hpp"

namespace conddp {

class AtomicFiles;

/// The value of `format` in an mpc.json, and the names of the files of a closed loop.
inline constexpr std::string_view kMpcFormat = "conddp.mpc/1";
inline constexpr const char* kLoopFile = "mpc.json";
inline constexpr const char* kPlantFile = "closed_loop.csv";
inline constexpr const char* kTicksFile = "ticks.csv";
inline constexpr const char* kTickTimesFile = "tick_times.csv";

/// All that the files of a closed loop are written from.
struct LoopRun {
  const LoopTask& task;
  const ClosedLoopResult& result;
  std::vector<std::string> overrides;  ///< settings of the command line, as given
};

/// A time as tables have it, without the digits that sums of decimal numbers leave behind.
double tabulated_time(double time);

/// The first line of closed_loop.csv, without its end.
std::string closed_loop_header(const LoopTask& task);

/// closed_loop.csv: t, phase, states, controls and contact forces of the plant, one row a step and
/// one for the last state, which has no controls and forces. Cells of contacts that are open are
/// empty.
std::string closed_loop_csv(const LoopRun& run);

/// ticks.csv: one row a tick. Cells of what is not finite, or of solves that were none, are empty.
std::string ticks_csv(const LoopRun& run);

/// tick_times.csv: wall-clock times of preparation and feedback, one row a tick. The only file of a
/// closed loop with a simulated clock that differs between two runs.
std::string tick_times_csv(const LoopRun& run);

/// mpc.json: what was simulated and how it ended (schemas/mpc.schema.json).
OrderedJson loop_json(const LoopRun& run);

/// Adds the four files, in a folder, to those that appear together. Returns their paths.
std::vector<std::filesystem::path> add_loop(const LoopRun& run, const std::filesystem::path& folder,
                                            AtomicFiles& files);

/// Writes the four files into a folder, which is made if needed: all of them or, with an
/// OutputError, none. Returns their paths.
std::vector<std::filesystem::path> write_loop(const LoopRun& run,
                                              const std::filesystem::path& folder);

}  // namespace conddp
