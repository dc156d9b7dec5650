#pragma once

#include <memory>
#include <string>

#include "base/json/ordered_json.hpp"
#include "output/solution/input_files.hpp"
#include "problem_file/assemble/build_mpc.hpp"

namespace conddp {

/// Rebuilds the loop of an mpc.json, as rebuild_problem() does for solutions.
std::unique_ptr<LoopTask> rebuild_loop(const OrderedJson& document, const std::string& file,
                                       const std::filesystem::path& problem, Diagnostics& out);

/// Input files of a loop: robots of the problem, its data, and files of a plant that differs from
/// the model.
InputFiles input_files(const LoopTask& task);

/// The reason why a loop ended early, in a sentence; empty if it did not.
std::string reason_of_end(const LoopTask& task, const ClosedLoopResult& result);

/// Simulates the loop. `observe`, unless null, is called with the controller after each tick.
ClosedLoopResult run_loop(const LoopTask& task, std::function<void(const Mpc&)> observe = nullptr);

}  // namespace conddp
