#include "output/mpc/plant_replay.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace conddp {
namespace {

constexpr double kTimeDecimal = 1e-9;  ///< s
/// Tolerance on the length of a step, s: both of its times are rounded, and the loop treats lengths
/// that differ by kSameTime as equal.
constexpr double kLengthError = 2 * kTimeDecimal;
/// Extension of a step for the rate at its end, s.
constexpr double kProbe = 1e-6;

/// True if a row, which ends at `next`, represents an event at `time`: the two differ only by
/// decimals. No step extends beyond such a time.
bool stands_for(double row, double next, double time) {
  return is_before(time, next) && std::abs(time - row) <= kLengthError;
}

bool all_finite(const std::vector<double>& x) {
  return std::all_of(x.begin(), x.end(), [](double value) { return std::isfinite(value); });
}

/// The plant of a loop without its controller.
class LonePlant {
 public:
  /// `line` belongs to the task and must outlive this object.
  LonePlant(const LoopTask& task, const TimeLine& line)
      : manifold_(task.built.problem->manifold()),
        loop_(task.mpc.loop),
        motions_(loop_.plant, loop_.step, line) {}

  /// Time of the event that a row represents, if the plant changes or jumps at the row; otherwise
  /// the row's own time. The row ends at `next`.
  double moment(double row, double next) const {
    double latest = row;
    for (const double begin : motions_.begins())
      if (stands_for(row, next, begin)) latest = std::max(latest, begin);
    for (const Jump& jump : loop_.jumps)
      if (stands_for(row, next, jump.at)) latest = std::max(latest, jump.at);
    return latest;
  }
  /// Steps a state forward with a control.
  void step(double time, double length, const double* u, double* x) {
    motions_.at(time).step(time, length, u, x);
  }
  /// Applies the events at a time to a state: jumps, and instantaneous phases. Times must increase
  /// from call to call.
  void happen(double time, double* x) {
    for (; jumps_ < loop_.jumps.size() && !is_before(time, loop_.jumps[jumps_].at); ++jumps_)
      manifold_.integrate(x, loop_.jumps[jumps_].tangent.data(), x);
    motions_.at(time).pass_instants(time, x);
  }

 private:
  const StateManifold& manifold_;
  const ClosedLoopOptions& loop_;
  PlantMotions motions_;
  std::size_t jumps_ = 0;  ///< applied so far
};

/// Replays the plant row by row.
class RowByRow {
 public:
  RowByRow(const PlantRows& rows, const LoopTask& task)
      : rows_(rows),
        task_(task),
        line_(task.built.problem, task.mpc.controller.hold),
        plant_(task, line_),
        appraisal_(line_, task.mpc.loop.finds_contacts()),
        stop_(task.mpc.loop.stop),
        names_(tangent_columns(task.built)),
        tangent_(task.built.problem->ndx()) {}

  PlantReplay run() {
    std::vector<double> x = task_.built.problem->initial_state();
    const std::size_t last = rows_.times.size() - 1;
    compare_events(0, 0, x);
    for (std::size_t i = 0; i < last; ++i) {
      appraise(i);
      const double rate = step(i, x);
      compare_events(i + 1, rate, x);
      result_.goes_on_after_end |= ended(i);
    }
    result_.end = end(last);
    if (result_.end == LoopEnd::finished && !line_.is_held() &&
        !is_before(task_.mpc.loop.duration, line_.end()))
      count(appraisal_.of_end(rows_.x[last].data()));
    return std::move(result_);
  }

 private:
  /// End time of a row, infinite for the last row.
  double next_time(std::size_t row) const {
    return row + 1 < rows_.times.size() ? rows_.times[row + 1] : HUGE_VAL;
  }

  /// The time that a row represents. Rows have nine decimals; the loop's exact times are the ends
  /// of knots, jumps, and changes of the plant.
  double moment(std::size_t row) const {
    const double time = rows_.times[row], next = next_time(row), end = line_.at(time).end;
    return std::max(stands_for(time, next, end) ? end : time, plant_.moment(time, next));
  }

  /// Steps the state of a row to the next row. Returns the rate of change of the result with the
  /// step length, which times of nine decimals leave uncertain.
  double step(std::size_t row, std::vector<double>& x) {
    const double time = moment(row), length = next_time(row) - rows_.times[row];
    const double* u = rows_.u[row].data();
    std::vector<double> later = rows_.x[row];
    plant_.step(time, length + kProbe, u, later.data());
    x = rows_.x[row];
    plant_.step(time, length, u, x.data());
    task_.built.problem->manifold().difference(x.data(), later.data(), tangent_.data());
    double largest = 0;
    for (const double entry : tangent_) largest = std::max(largest, std::abs(entry));
    return largest / kProbe;
  }

  /// Compares a row with the plant's state after the events at its time; the last row may precede
  /// them.
  void compare_events(std::size_t row, double rate, std::vector<double>& x) {
    const std::vector<double> before = x;
    plant_.happen(moment(row), x.data());
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
      const double allowed = kLengthError * (1 + rate), distance = std::abs(tangent_[i]);
      const double excess = std::isfinite(distance) ? distance / allowed : HUGE_VAL;
      if (excess <= worst.excess) continue;
      worst.excess = excess;
      worst.deviation = distance;
      worst.allowed = allowed;
      worst.place = fmt::format("{:g} s, {}", rows_.times[row], names_[i]);
    }
    return worst;
  }

  /// Updates the time line to the commands known at the tick before `time`.
  void take_commands(double time) {
    const double tick = task_.mpc.controller.tick;
    const double measured = std::floor((time + kTimeDecimal) / tick) * tick;
    const std::vector<LoopCommand>& commands = task_.mpc.loop.commands;
    for (; commands_ < commands.size() && !is_before(measured, commands[commands_].at); ++commands_)
      line_.take_numbers(commands[commands_].numbers);
  }

  void appraise(std::size_t row) {
    const double time = moment(row), length = next_time(row) - rows_.times[row];
    take_commands(time);
    const StepFigures figures =
        appraisal_.of_step(time, length, rows_.u[row].data(), rows_.x[row].data());
    result_.cost_rounding += std::abs(figures.cost) * kLengthError / length;
    count(figures);
  }

  void count(const StepFigures& figures) {
    result_.cost += figures.cost;
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
  TimeLine line_;
  LonePlant plant_;
  Appraisal appraisal_;
  StopCheck stop_;
  std::vector<std::string> names_;
  std::vector<double> tangent_;
  std::size_t commands_ = 0;  ///< applied to the time line
  PlantReplay result_;
};

}  // namespace

PlantReplay replay_plant(const PlantRows& rows, const LoopTask& task) {
  return RowByRow(rows, task).run();
}

}  // namespace conddp
