#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mpc/appraisal.hpp"
#include "mpc/mpc.hpp"
#include "mpc/plant_motions.hpp"

namespace conddp {

/// What is wanted from a time on: the numbers of a problem, and the path of the node at which
/// windows end (Mpc::take_numbers). The first tick that measures no earlier learns of it. The time
/// is that of the controller's time line, with which re-timing moves it.
struct LoopCommand {
  double at = 0;  ///< s
  std::shared_ptr<const ShootingProblem> numbers;
  std::shared_ptr<const StatePath> terminal_path = nullptr;
};

/// A displacement of the plant's state at a time.
struct Jump {
  double at = 0;  ///< s
  std::vector<double> tangent;
};

/// Normal random numbers that are added to each measured state.
struct MeasurementNoise {
  std::vector<double> sigma;  ///< standard deviation, one a tangent coordinate
  std::uint64_t seed = 1;
};

struct ClosedLoopOptions {
  double duration = 1;  ///< s
  /// From time 0 on, in order; empty: the plant is the model.
  std::vector<PlantPeriod> plant;
  StepRule step;                      ///< of the plant
  std::vector<Jump> jumps;            ///< in the order of their times
  std::vector<LoopCommand> commands;  ///< likewise
  std::optional<MeasurementNoise> noise;
  std::optional<StopCondition> stop;
  /// Changes what is measured at a tick before the controller gets it; null: nothing does.
  std::function<void(int tick, std::vector<double>& x)> distort;
  /// Asked before each tick; true ends the loop.
  std::function<bool()> interrupted;
  /// Gets to see the controller after each tick; null: none.
  std::function<void(const Mpc&)> observe;

  /// Whether the plant has a motion of its own, whose contact forces are not those of the model.
  bool finds_contacts() const;
};

/// How a closed loop ended.
enum class LoopEnd {
  finished,     ///< the duration, or the end of a time line that is not held
  stopped,      ///< the stop condition was met
  diverged,     ///< the plant's state is not finite
  interrupted,  ///< the caller asked to stop
};
/// The name in outputs.
std::string_view to_string(LoopEnd end);

/// One step of the plant: when it begins, in which state, with which control.
struct PlantStep {
  double time;    ///< s
  double length;  ///< s
  std::vector<double> x, u;
  double line_time;                         ///< s, on the controller's time line (Mpc::line_time)
  std::vector<double> contact_forces = {};  ///< PlantMotion::contact_forces
};

struct ClosedLoopResult {
  LoopEnd end = LoopEnd::finished;
  double end_time = 0;  ///< s
  std::string failure;  ///< PlantMotion::failure() of the last step, where that ended the loop
  std::vector<PlantStep> steps;
  std::vector<double> last_state;  ///< after the last step
  std::vector<TickRecord> ticks;
  /// Σ of running costs at the states of the plant, in proportion to the steps; not of impulses,
  /// nor of contact forces where the plant finds its own.
  double cost = 0;
  /// Largest one of a constraint at the plant's states, likewise.
  double violation = 0;
};

/// Lets a controller that has not ticked yet drive the plant from the problem's initial state.
/// Deterministic: the clock is simulated.
ClosedLoopResult run_closed_loop(Mpc& mpc, const ClosedLoopOptions& options);

}  // namespace conddp
