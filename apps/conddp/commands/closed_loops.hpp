#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "arguments/problem_arguments.hpp"
#include "output/mpc/loop_files.hpp"
#include "terminal/messages.hpp"

namespace conddp {

/// Arguments of `conddp mpc`.
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

/// The folder for a loop's outputs.
std::filesystem::path output_folder(const MpcArguments& arguments, const ProblemSpec& spec);

/// Simulates a loop until its end or a signal. `observe`, unless null, is called with the
/// controller after each tick.
ClosedLoopResult simulate_task(const MpcArguments& arguments, LoopTask& task,
                               std::function<void(const Mpc&)> observe = nullptr);

/// Summary of a loop for users, and the paths of its files.
std::string loop_summary(const LoopRun& run, const std::vector<std::filesystem::path>& written);

}  // namespace conddp
