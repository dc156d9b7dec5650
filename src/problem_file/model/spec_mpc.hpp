#pragma once

#include <cstdint>

#include "ocp/step/integrator.hpp"
#include "problem_file/model/spec_cost.hpp"
#include "problem_file/model/spec_gait.hpp"
#include "problem_file/model/spec_robot.hpp"
#include "problem_file/model/spec_stepping.hpp"
#include "problem_file/model/spec_terminal.hpp"
#include "problem_file/yaml/setting.hpp"

namespace conddp {

/// Continuation after the end of the phases: none, their last knot repeated, or further cycles of
/// the file's gait.
enum class AfterTheEnd { kNone, kHold, kGait };

/// Terminal cost of windows that end before the phases do: none, the file's `terminal`, or the
/// cost-to-go of a regulator.
enum class WindowEnd { kNothing, kTerminal, kRegulator };

/// A disturbance of the plant at a time: a jump of its state, or a temporary push on a frame.
struct DisturbanceSpec {
  Place place;
  Located<double> at;                  ///< s
  std::optional<ComponentsSpec> jump;  ///< of the state, in tangent components
  std::optional<WrenchSpec> push;
  double duration = 0;  ///< of a push, s
};

/// Normal noise added to the measurement.
struct NoiseSpec {
  ComponentsSpec sigma;  ///< standard deviation, in tangent components
  std::uint64_t seed = 1;
};

/// Ticks whose answer arrives late, independent of the clock.
struct LateSpec {
  double share = 1;                ///< of the ticks, drawn at random
  Located<double> at{0, {}};       ///< first time, s
  std::optional<double> duration;  ///< s; absent: to the end of the loop
  std::uint64_t seed = 1;
};

/// Simulated plant in place of the model.
struct MpcPlantSpec {
  std::vector<Setting> settings;  ///< of the problem file
  Place place;                    ///< of the settings
  std::optional<Located<Integrator>> integrator;
  std::optional<Located<double>> dt;  ///< longest step, s
  /// The file's contacts open and close by simulation, on the ground.
  std::optional<Place> simulated_contacts;
  std::vector<TouchedSpec> ground = {TouchedSpec{}};
};

/// Bounds on how much earlier phases may begin and how much longer they may last.
struct RetimeSpec {
  Place place;
  Located<double> early, late;  ///< s
};

/// Fallback controller after several ticks in a row without a plan.
struct FallbackSpec {
  Place place;
  int after = 3;
  std::optional<Name> name;               ///< target state: a configuration or "initial"
  StateSpec to;                           ///< target state if it has no name; the controls hold it
  std::optional<TerminalLqrSpec> by_lqr;  ///< instead: a regulator's state, held with its gains
};

/// The section `mpc`: a closed loop.
struct MpcSpec {
  Place place;
  Located<double> horizon, tick, duration;  ///< s
  std::optional<int> iterations = 1;        ///< per tick; absent: to the solver's tolerances
  Place iterations_place;                   ///< empty if the key is missing
  Located<AfterTheEnd> repeat{AfterTheEnd::kHold, {}};
  Located<WindowEnd> window_end{WindowEnd::kNothing, {}};
  std::optional<TerminalLqrSpec> terminal_lqr;   ///< of windows that end with a regulator
  Located<double> delay;                         ///< s
  std::optional<Located<double>> feedback_rate;  ///< Hz
  MpcPlantSpec plant;
  std::vector<DisturbanceSpec> disturbances;
  std::optional<NoiseSpec> noise;
  std::vector<LateSpec> late;
  std::vector<GaitCommand> commands;     ///< unknown to the controller before their times
  std::optional<Place> measured_swings;  ///< swings begin at the measured feet
  std::optional<RetimeSpec> retime;
  std::optional<FallbackSpec> fallback;
  std::vector<ConstraintSpec> stop_when;  ///< bounds on states; the loop ends when one is violated
};

}  // namespace conddp
