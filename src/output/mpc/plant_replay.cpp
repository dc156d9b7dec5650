#include "output/mpc/plant_replay.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace conddp {
namespace {

constexpr double kTimeDecimal = 1e-9;  ///< s
/// By how much the length of a step may be off, s: both of its times are rounded, and the loop
/// takes lengths that differ by kSameTime for one.
constexpr double kLengthError = 2 * kTimeDecimal;
/// By how much longer a step is taken for the rate at its end, s.
constexpr double kProbe = 1e-6;

/// Whether a row, which ends at `next`, stands for something that happens at a time: so it does
/// where decimals alone tell the two apart. No step goes on beyond such a time.
bool stands_for(double row, double next, double time) {
  return is_before(time, next) && std::abs(time - row) <= kLengthError;
}

bool all_finite(const std::vector<double>& x) {
  return std::all_of(x.begin(), x.end(), [](double value) { return std::isfinite(value); });
}

/// The plant of a loop by itself.
class LonePlant {
 public:
  /// `line`: the task's, which has to live longer than this.
  LonePlant(const LoopTask& task, const TimeLine& line)
      : manifold_(task.built.problem->manifold()),
        loop_(task.mpc.loop),
        motions_(loop_.plant, loop_.step, line) {}

  /// The time that a row which ends at `next` stands for, where something changes then: the plant,
  /// or its state by a jump. Otherwise the row's own.
  double moment(double row, double next) const {
    double latest = row;
    for (const double begin : motions_.begins())
      if (stands_for(row, next, begin)) latest = std::max(latest, begin);
    for (const Jump& jump : loop_.jumps)
      if (stands_for(row, next, jump.at)) latest = std::max(latest, jump.at);
    return latest;
  }
  /// Moves a state on, with a control.
  void step(double time, double length, const double* u, double* x) {
    motions_.at(time).step(time, length, u, x);
  }
  /// What happens to a state at a time that comes after those of former calls: jumps, and instants
  /// of the phases.
  void happen(double time, double* x) {
    for (; jumps_ < loop_.jumps.size() && !is_before(time, loop_.jumps[jumps_].at); ++jumps_)
      manifold_.integrate(x, loop_.jumps[jumps_].tangent.data(), x);
    motions_.at(time).pass_instants(time, x);
  }

 private:
  const StateManifold& manifold_;
  const ClosedLoopOptions& loop_;
  PlantMotions motions_;
  std::size_t jumps_ = 0;  ///< that have happened
};

/// Goes from row to row.
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
  /// When a row ends; the last one does not.
  double next_time(std::size_t row) const {
    return row + 1 < rows_.times.size() ? rows_.times[row + 1] : HUGE_VAL;
  }

  /// The time that a row stands for. The loop's own times, of which rows have nine decimals, are
  /// those at which knots end, jumps happen and plants change.
  double moment(std::size_t row) const {
    const double time = rows_.times[row], next = next_time(row), end = line_.at(time).end;
    return std::max(stands_for(time, next, end) ? end : time, plant_.moment(time, next));
  }

  /// Moves the state of a row on to the next one. How fast the result changes with the step's
  /// length: by that, times of nine decimals leave it open.
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

  /// Compares a row with where the plant gets, after what happens at its time; the last row may
  /// come before that.
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

  /// The numbers of the time line are those that the tick before a time knows of.
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
  std::size_t commands_ = 0;  ///< that the time line has taken
  PlantReplay result_;
};

}  // namespace

PlantReplay replay_plant(const PlantRows& rows, const LoopTask& task) {
  return RowByRow(rows, task).run();
}

}  // namespace conddp
