#include "output/mpc/plant_replay.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace conddp {
namespace {

constexpr double kTimeDecimal = 1e-9;  ///< s

bool all_finite(const std::vector<double>& x) {
  return std::all_of(x.begin(), x.end(), [](double value) { return std::isfinite(value); });
}

/// The plant of a loop by itself.
class LonePlant {
 public:
  explicit LonePlant(const LoopTask& task)
      : manifold_(task.built.problem->manifold()), loop_(task.mpc.loop) {
    const bool held = task.mpc.controller.hold;
    if (loop_.plant.empty()) add(0, task.built.problem, held);
    for (const PlantPeriod& period : loop_.plant) {
      if (period.motion != nullptr)
        periods_.push_back({period.from, period.motion});
      else
        add(period.from, period.problem, held);
    }
  }

  /// Moves a state on, with a control.
  void step(double time, double length, const double* u, double* x) {
    at(time).step(time, length, u, x);
  }
  /// What happens to a state at a time that comes after those of former calls: jumps, and instants
  /// of the phases.
  void happen(double time, double* x) {
    for (; jumps_ < loop_.jumps.size() && !is_before(time, loop_.jumps[jumps_].at); ++jumps_)
      manifold_.integrate(x, loop_.jumps[jumps_].tangent.data(), x);
    at(time).pass_instants(time, x);
  }

 private:
  struct Period {
    double from;
    std::shared_ptr<PlantMotion> motion;
  };

  void add(double from, std::shared_ptr<const ShootingProblem> problem, bool held) {
    lines_.push_back(std::make_unique<TimeLine>(std::move(problem), held));
    periods_.push_back({from, std::make_shared<Simulation>(*lines_.back(), loop_.step)});
  }
  PlantMotion& at(double time) {
    PlantMotion* current = periods_.front().motion.get();
    for (const Period& period : periods_)
      if (!is_before(time, period.from)) current = period.motion.get();
    return *current;
  }

  const StateManifold& manifold_;
  const ClosedLoopOptions& loop_;
  std::vector<std::unique_ptr<TimeLine>> lines_;
  std::vector<Period> periods_;
  std::size_t jumps_ = 0;  ///< that have happened
};

/// Goes from row to row.
class RowByRow {
 public:
  RowByRow(const PlantRows& rows, const LoopTask& task)
      : rows_(rows),
        task_(task),
        plant_(task),
        line_(task.built.problem, task.mpc.controller.hold),
        appraisal_(line_),
        stop_(task.mpc.loop.stop),
        names_(tangent_columns(task.built)),
        tangent_(task.built.problem->ndx()) {}

  PlantReplay run() {
    std::vector<double> x = task_.built.problem->initial_state();
    const std::size_t last = rows_.times.size() - 1;
    compare_events(0, 0, x);
    for (std::size_t i = 0; i < last; ++i) {
      x = rows_.x[i];
      appraise(i);
      const double length = rows_.times[i + 1] - rows_.times[i];
      plant_.step(rows_.times[i], length, rows_.u[i].data(), x.data());
      compare_events(i + 1, largest_rate(rows_.x[i], x, length), x);
      result_.goes_on_after_end |= ended(i);
    }
    result_.end = end(last);
    return std::move(result_);
  }

 private:
  /// How fast a state moves: by that, times of nine decimals leave it open.
  double largest_rate(const std::vector<double>& from, const std::vector<double>& to,
                      double length) {
    task_.built.problem->manifold().difference(from.data(), to.data(), tangent_.data());
    double largest = 0;
    for (const double entry : tangent_) largest = std::max(largest, std::abs(entry));
    return largest / length;
  }

  /// Compares a row with where the plant gets, after what happens at its time; the last row may
  /// come before that.
  void compare_events(std::size_t row, double rate, std::vector<double>& x) {
    const std::vector<double> before = x;
    plant_.happen(rows_.times[row], x.data());
    PlantReplay after = compared(row, rate, x);
    if (row + 1 == rows_.times.size())
      if (PlantReplay without = compared(row, rate, before); without.excess < after.excess)
        after = std::move(without);
    if (after.excess <= result_.excess) return;
    result_.excess = after.excess;
    result_.deviation = after.deviation;
    result_.allowed = after.allowed;
    result_.place = after.place;
  }

  PlantReplay compared(std::size_t row, double rate, const std::vector<double>& x) {
    PlantReplay worst;
    if (!all_finite(x) && !all_finite(rows_.x[row])) return worst;
    task_.built.problem->manifold().difference(x.data(), rows_.x[row].data(), tangent_.data());
    for (std::size_t i = 0; i < tangent_.size(); ++i) {
      const double allowed = kTimeDecimal * (1 + rate), distance = std::abs(tangent_[i]);
      const double excess = std::isfinite(distance) ? distance / allowed : HUGE_VAL;
      if (excess <= worst.excess) continue;
      worst.excess = excess;
      worst.deviation = distance;
      worst.allowed = allowed;
      worst.place = fmt::format("{:g} s, {}", rows_.times[row], names_[i]);
    }
    return worst;
  }

  /// The numbers of the time line are those that the tick before a time knows of.
  void take_commands(double time) {
    const double tick = task_.mpc.controller.tick;
    const double measured = std::floor((time + kTimeDecimal) / tick) * tick;
    const std::vector<LoopCommand>& commands = task_.mpc.loop.commands;
    for (; commands_ < commands.size() && !is_before(measured, commands[commands_].at); ++commands_)
      line_.take_numbers(commands[commands_].numbers);
  }

  void appraise(std::size_t row) {
    take_commands(rows_.times[row]);
    const double length = rows_.times[row + 1] - rows_.times[row];
    const StepFigures figures =
        appraisal_.of_step(rows_.times[row], length, rows_.u[row].data(), rows_.x[row].data());
    result_.cost += figures.cost;
    result_.cost_rounding += std::abs(figures.cost) * kTimeDecimal / length;
    result_.violation = std::max(result_.violation, figures.violation);
  }

  bool ended(std::size_t row) const {
    return !all_finite(rows_.x[row]) || stop_.is_met(rows_.x[row].data());
  }

  LoopEnd end(std::size_t last) const {
    if (!all_finite(rows_.x[last])) return LoopEnd::diverged;
    if (stop_.is_met(rows_.x[last].data())) return LoopEnd::stopped;
    const double duration = task_.mpc.loop.duration;
    const double whole = line_.is_held() ? duration : std::min(duration, line_.end());
    return is_before(rows_.times[last] + kTimeDecimal, whole) ? LoopEnd::interrupted
                                                              : LoopEnd::finished;
  }

  const PlantRows& rows_;
  const LoopTask& task_;
  LonePlant plant_;
  TimeLine line_;
  Appraisal appraisal_;
  StopCheck stop_;
  std::vector<std::string> names_;
  std::vector<double> tangent_;
  std::size_t commands_ = 0;  ///< that the time line has taken
  PlantReplay result_;
};

}  // namespace

PlantReplay replay_plant(const PlantRows& rows, const LoopTask& task) {
  return RowByRow(rows, task).run();
}

}  // namespace conddp
