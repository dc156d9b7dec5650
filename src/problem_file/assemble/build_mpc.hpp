#pragma once

#include <memory>
#include <optional>

#include "mpc/closed_loop.hpp"
#include "problem_file/assemble/build.hpp"

namespace conddp {

/// The closed loop of a problem file: the controller, and the plant it drives.
struct BuiltMpc {
  MpcOptions controller;
  ClosedLoopOptions loop;
  /// Files of the robots and data of the plant if it differs from the model.
  std::vector<InputFile> plant_files;
};

/// A problem and the closed loop around it.
struct LoopTask {
  BuiltProblem built;  ///< with enough gait cycles for the loop
  BuiltMpc mpc;
};

/// Message and hint: a loop without `stop_when` does not show which disturbances it withstands.
inline constexpr const char* kNothingStopsALoop = "a loop without 'stop_when' never stops early";
inline constexpr const char* kHowToStopALoop =
    "define when it has failed: 'stop_when: {fallen: {residual: state, columns: theta, lower: 2, "
    "upper: 4}}'";

/// Builds the section `mpc` of a problem, which must exist. Reports keys without meaning in a loop
/// with their places. `built` must outlive the result.
std::optional<BuiltMpc> build_mpc(const BuiltProblem& built, Diagnostics& out);

/// Builds the loop of the problem that was read. Null with errors if it lacks a section `mpc` or
/// the section is invalid; null if none was read.
std::unique_ptr<LoopTask> build_loop(std::optional<ProblemSpec> spec, const BuildOptions& options,
                                     Diagnostics& out);
/// The same for a problem built before.
std::unique_ptr<LoopTask> build_loop(const BuiltProblem& built, const BuildOptions& options,
                                     Diagnostics& out);

}  // namespace conddp
