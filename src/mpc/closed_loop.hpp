#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mpc/appraisal.hpp"
#include "mpc/mpc.hpp"
#include "mpc/plant_motion.hpp"

namespace conddp {

/// New numbers of a problem from a time on, and a new path of the end node of windows
/// (Mpc::take_numbers). The first tick that measures at or after `at` receives them. `at` is a time
/// on the controller's time line and moves with re-timing.
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

/// Normally distributed noise that is added to each measured state.
struct MeasurementNoise {
  std::vector<double> sigma;  ///< standard deviation of each tangent coordinate
  std::uint64_t seed = 1;
};

struct ClosedLoopOptions {
  double duration = 1;  ///< s
  /// Periods from time 0 on, in order. If empty, the plant is the model.
  std::vector<PlantPeriod> plant;
  StepRule step;                      ///< step rule of the plant
  std::vector<Jump> jumps;            ///< sorted by time
  std::vector<LoopCommand> commands;  ///< sorted by time
  std::optional<MeasurementNoise> noise;
  std::optional<StopCondition> stop;
  /// Changes the measured state of a tick before the controller receives it; null for no change.
  std::function<void(int tick, std::vector<double>& x)> distort;
  /// Called before each tick; true ends the loop.
  std::function<bool()> interrupted;
  /// Called with the controller after each tick; may be null.
  std::function<void(const Mpc&)> observe;

  /// True if the plant has its own motion, whose contact forces differ from the model's.
  bool finds_contacts() const;
};

/// How a closed loop ended.
enum class LoopEnd {
  finished,     ///< reached the duration, or the end of a time line that is not held
  stopped,      ///< met the stop condition
  diverged,     ///< plant state not finite
  interrupted,  ///< interrupted by the caller
};
/// Name in outputs.
std::string_view to_string(LoopEnd end);

/// One step of the plant: its start, initial state and control.
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
  std::string failure;  ///< PlantMotion::failure() of the last step, if the plant diverged
  std::vector<PlantStep> steps;
  std::vector<double> last_state;  ///< after the last step
  std::vector<TickRecord> ticks;
  /// Σ of running costs at the plant's states, scaled by step length. Excludes impulses, and costs
  /// on contact forces if the plant finds its own contacts.
  double cost = 0;
  /// Largest constraint violation at the plant's states, with the same exclusions.
  double violation = 0;
};

/// Runs a controller that has not ticked yet in closed loop with the plant, from the problem's
/// initial state. Deterministic: the clock is simulated.
ClosedLoopResult run_closed_loop(Mpc& mpc, const ClosedLoopOptions& options);

/// Bisects a range for the largest number that a loop survives, down to an interval of `width`. The
/// ends are tried first. Exact if it survives all numbers below a threshold and none above it.
/// Empty if it does not survive `low`.
std::optional<double> largest_survived(double low, double high, double width,
                                       const std::function<bool(double)>& survives);

}  // namespace conddp
