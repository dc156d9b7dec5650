#include "commands/closed_loops.hpp"

#include <algorithm>
#include <chrono>

#include <fmt/format.h>

#include "terminal/interrupt.hpp"

namespace conddp {
namespace {

/// The value that `percent` of the values (s) do not exceed, ms.
double percentile(std::vector<double> values, int percent) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return 1e3 * values[(values.size() - 1) * percent / 100];
}

std::string times_line(const ClosedLoopResult& result) {
  std::vector<double> preparation, feedback;
  for (const TickRecord& tick : result.ticks) {
    preparation.push_back(tick.preparation);
    feedback.push_back(tick.feedback);
  }
  const auto line = [](const char* what, const std::vector<double>& times) {
    return fmt::format("{:<12} {:.3g} ms median, {:.3g} ms 95 %, {:.3g} ms longest\n", what,
                       percentile(times, 50), percentile(times, 95), percentile(times, 100));
  };
  return line("preparation", preparation) + line("feedback", feedback);
}

auto count_of(const ClosedLoopResult& result, TickOutcome outcome) {
  return std::count_if(result.ticks.begin(), result.ticks.end(),
                       [outcome](const TickRecord& tick) { return tick.outcome == outcome; });
}

/// Time of a steady clock, s.
double wall_clock() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double>(now).count();
}

}  // namespace

ClosedLoopResult simulate_task(const MpcArguments& arguments, LoopTask& task,
                               std::function<void(const Mpc&)> observe) {
  task.mpc.loop.interrupted = [] { return InterruptGuard::signal() != 0; };
  if (arguments.realtime) task.mpc.controller.clock = wall_clock;
  return run_loop(task, std::move(observe));
}

std::string loop_summary(const LoopRun& run, const std::vector<std::filesystem::path>& written) {
  const ClosedLoopResult& result = run.result;
  const auto failed =
      static_cast<std::ptrdiff_t>(result.ticks.size()) - count_of(result, TickOutcome::planned);
  const std::string reason = reason_of_end(run.task, result);
  std::string text = fmt::format(
      "{}: {} at {:g} s of {:g} s{}{}\n", run.task.built.facts().name.value, to_string(result.end),
      result.end_time, run.task.mpc.loop.duration, reason.empty() ? "" : ": ", reason);
  text += fmt::format("{:<12} {} of {:g} s by {}, {} failed\n", "ticks", result.ticks.size(),
                      run.task.mpc.controller.tick, run.task.mpc.controller.solver, failed);
  text += fmt::format("{:<12} {:.8g}\n{:<12} {:.2g}\n", "cost", result.cost, "violation",
                      result.violation);
  text += times_line(result);
  if (run.task.mpc.controller.clock)
    text += fmt::format("{:<12} of the wall, {} late: outputs differ from run to run\n", "clock",
                        count_of(result, TickOutcome::late));
  for (const auto& path : written) text += path.string() + '\n';
  return text;
}

}  // namespace conddp
