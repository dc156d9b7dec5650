#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "mpc/closed_loop.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// The closed loop of a problem file: the controller, and what it is to drive.
struct BuiltMpc {
  MpcOptions controller;
  ClosedLoopOptions loop;
  /// The files of the plant, where it is not the model.
  std::vector<std::shared_ptr<const ProblemSpec>> plant_specs;
  std::vector<InputFile> plant_files;  ///< robots and data of such a plant
};

/// Why a loop without `stop_when` tells nothing of what it withstands, and what helps.
inline constexpr const char* kNothingStopsALoop = "a loop without 'stop_when' never stops early";
inline constexpr const char* kHowToStopALoop =
    "define when it has failed: 'stop_when: {fallen: {residual: state, columns: theta, lower: 2, "
    "upper: 4}}'";

/// The problem with as many cycles of its gait as a loop needs that repeats it: read again from the
/// text of its file. Nothing where there is none, which is reported.
std::optional<ProblemSpec> repeat_gait(const ProblemSpec& spec, Diagnostics& out);

/// Builds the section `mpc` of a spec, which has to be there, for the problem that was built from
/// it. What has no meaning in a loop is reported with its place. `spec` and `built` must outlive
/// the result.
std::optional<BuiltMpc> build_mpc(const ProblemSpec& spec, const BuiltProblem& built,
                                  Diagnostics& out);

}  // namespace conddp
