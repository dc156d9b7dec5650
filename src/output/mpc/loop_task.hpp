#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/json/ordered_json.hpp"
#include "output/solution/input_files.hpp"
#include "problem_file/build/build_mpc.hpp"

namespace conddp {

/// A problem file and the closed loop around it.
struct LoopTask {
  std::unique_ptr<const ProblemSpec> spec;  ///< with as many cycles of its gait as the loop needs
  BuiltProblem built;
  BuiltMpc mpc;
};

/// Builds the loop of a problem file. Null with errors: where the file has no section `mpc`, or
/// where that has no meaning.
std::unique_ptr<LoopTask> build_loop(ProblemSpec spec, const BuildOptions& options,
                                     Diagnostics& out);

/// Builds the loop that an mpc.json was made from again, as rebuild_problem() does for solutions.
std::unique_ptr<LoopTask> rebuild_loop(const OrderedJson& document, const std::string& file,
                                       const std::filesystem::path& problem, Diagnostics& out);

/// The files that a loop is made of: robots of the problem; its data, and what a plant reads that
/// is not the model.
InputFiles input_files(const LoopTask& task);

/// Why a loop ended before its duration, in a sentence; empty where it did not.
std::string reason_of_end(const LoopTask& task, const ClosedLoopResult& result);

/// Simulates the loop. `observe` gets to see the controller after each tick; null: none.
ClosedLoopResult run_loop(const LoopTask& task, std::function<void(const Mpc&)> observe = nullptr);

}  // namespace conddp
