#pragma once

#include <cstdint>

#include "ocp/knot/integrator.hpp"
#include "problem_file/spec/spec_cost.hpp"
#include "problem_file/spec/spec_gait.hpp"
#include "problem_file/spec/spec_robot.hpp"
#include "problem_file/spec/spec_stepping.hpp"
#include "problem_file/spec/spec_terminal.hpp"
#include "problem_file/yaml/setting.hpp"

namespace conddp {

/// What follows the end of the phases: nothing, their last knot again and again, or further cycles
/// of the file's gait.
enum class AfterTheEnd { kNone, kHold, kGait };

/// What counts at the last node of windows that end before the phases do: nothing, the file's
/// `terminal`, or the cost-to-go of a regulator.
enum class WindowEnd { kNothing, kTerminal, kRegulator };

/// A change of the plant at a time: its state jumps, or a frame is pushed for a while.
struct DisturbanceSpec {
  Place place;
  Located<double> at;                  ///< s
  std::optional<ComponentsSpec> jump;  ///< of the state, in tangent components
  std::optional<WrenchSpec> push;
  double duration = 0;  ///< of a push, s
};

/// Normal random numbers that are added to what is measured.
struct NoiseSpec {
  ComponentsSpec sigma;  ///< standard deviation, in tangent components
  std::uint64_t seed = 1;
};

/// Answers of ticks that come too late, whatever the clock says.
struct LateSpec {
  double share = 1;                ///< of the ticks, drawn at random
  Located<double> at{0, {}};       ///< from when on, s
  std::optional<double> duration;  ///< s; none: to the end of the loop
  std::uint64_t seed = 1;
};

/// What moves in place of the model.
struct MpcPlantSpec {
  std::vector<Setting> settings;  ///< of the problem file
  Place place;                    ///< of the settings
  std::optional<Located<Integrator>> integrator;
  std::optional<Located<double>> dt;  ///< longest step, s
  /// The contacts of the file open and close by themselves, on the ground.
  std::optional<Place> simulated_contacts;
  std::vector<TouchedSpec> ground = {TouchedSpec{}};
};

/// By how much phases may begin earlier or last longer than planned.
struct RetimeSpec {
  Place place;
  Located<double> early, late;  ///< s
};

/// What controls where several ticks in a row have no plan.
struct FallbackSpec {
  Place place;
  int after = 3;
  std::optional<Name> name;               ///< the state: a configuration or "initial"
  StateSpec to;                           ///< the state otherwise, which the controls hold
  std::optional<TerminalLqrSpec> by_lqr;  ///< with the regulator's gains about its state instead
};

/// The section `mpc`: a closed loop.
struct MpcSpec {
  Place place;
  Located<double> horizon, tick, duration;  ///< s
  std::optional<int> iterations = 1;        ///< of a tick; none: to the solver's tolerances
  Place iterations_place;                   ///< none where the file has no such key
  Located<AfterTheEnd> repeat{AfterTheEnd::kHold, {}};
  Located<WindowEnd> window_end{WindowEnd::kNothing, {}};
  std::optional<TerminalLqrSpec> terminal_lqr;   ///< of windows that end with a regulator
  Located<double> delay;                         ///< s
  bool predict = true;                           ///< the state for the end of the delay
  std::optional<Located<double>> feedback_rate;  ///< Hz
  MpcPlantSpec plant;
  std::vector<DisturbanceSpec> disturbances;
  std::optional<NoiseSpec> noise;
  std::vector<LateSpec> late;
  std::vector<GaitCommand> commands;     ///< unknown to the controller before their times
  std::optional<Place> measured_swings;  ///< swings begin where the feet are
  std::optional<RetimeSpec> retime;
  std::optional<FallbackSpec> fallback;
  std::vector<ConstraintSpec> stop_when;  ///< of states: the loop ends where one does not hold
};

}  // namespace conddp
