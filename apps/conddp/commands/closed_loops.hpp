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
  bool realtime = false;
  std::string largest;
  std::string report;
};

/// Simulates a loop until its end or a signal. `observe`, unless null, is called with the
/// controller after each tick.
ClosedLoopResult simulate_task(const MpcArguments& arguments, LoopTask& task,
                               std::function<void(const Mpc&)> observe = nullptr);

/// Summary of a loop for users, and the paths of its files.
std::string loop_summary(const LoopRun& run, const std::vector<std::filesystem::path>& written);

/// The defect of a text as "KEY=[LOW, HIGH]" with two numbers; empty if valid.
std::string largest_defect(const std::string& text);

/// Searches for the largest value of the key of `--largest` whose loop survives, and writes the
/// trials with the files of that loop. Returns the exit code.
int search_largest(const MpcArguments& arguments);

}  // namespace conddp
