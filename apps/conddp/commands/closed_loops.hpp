#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "arguments/problem_arguments.hpp"
#include "output/mpc/loop_files.hpp"
#include "terminal/messages.hpp"

namespace conddp {

/// What `conddp mpc` can be told.
struct MpcArguments : ProblemArguments {
  std::string folder;
  bool quiet = false;
  bool json = false;
  bool verbose = false;
  bool realtime = false;
  std::string largest;
  std::string report;
};

Verbosity verbosity_of(const MpcArguments& arguments);

/// Where the outputs of a loop go.
std::filesystem::path output_folder(const MpcArguments& arguments, const ProblemSpec& spec);

/// Simulates a loop until its end or a signal. `observe` gets to see the controller after each
/// tick; null: none.
ClosedLoopResult simulate_task(const MpcArguments& arguments, LoopTask& task,
                               std::function<void(const Mpc&)> observe = nullptr);

/// What people read of a loop, and the paths of its files.
std::string loop_summary(const LoopRun& run, const std::vector<std::filesystem::path>& written);

}  // namespace conddp
