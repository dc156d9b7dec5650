#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "mpc/closed_loop.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// The closed loop of a problem file: the controller, and the plant it drives.
struct BuiltMpc {
  MpcOptions controller;
  ClosedLoopOptions loop;
  /// Problem files of the plant if it differs from the model.
  std::vector<std::shared_ptr<const ProblemSpec>> plant_specs;
  std::vector<InputFile> plant_files;  ///< files of the robots and data of that plant
};

/// Message and hint: a loop without `stop_when` does not show which disturbances it withstands.
inline constexpr const char* kNothingStopsALoop = "a loop without 'stop_when' never stops early";
inline constexpr const char* kHowToStopALoop =
    "define when it has failed: 'stop_when: {fallen: {residual: state, columns: theta, lower: 2, "
    "upper: 4}}'";

/// The problem with as many gait cycles as a loop with `repeat: gait` needs, read again from the
/// text of its file. Empty, with a report, if it lacks a gait or needs too many cycles.
std::optional<ProblemSpec> repeat_gait(const ProblemSpec& spec, Diagnostics& out);

/// Builds the section `mpc` of a spec, which must exist, for the problem built from the spec.
/// Reports keys without meaning in a loop with their places. `spec` and `built` must outlive the
/// result.
std::optional<BuiltMpc> build_mpc(const ProblemSpec& spec, const BuiltProblem& built,
                                  Diagnostics& out);

}  // namespace conddp
