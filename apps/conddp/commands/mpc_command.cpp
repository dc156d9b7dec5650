#include <algorithm>
#include <chrono>
#include <filesystem>

#include <fmt/format.h>

#include "arguments/problem_arguments.hpp"
#include "arguments/shared_arguments.hpp"
#include "base/files/atomic_file.hpp"
#include "base/json/json_text.hpp"
#include "commands/commands.hpp"
#include "output/mpc/loop_files.hpp"
#include "solvers/ddp/family.hpp"
#include "solvers/strategies/registry.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/messages.hpp"
#include "terminal/streams.hpp"

namespace conddp {
namespace {

struct MpcArguments : ProblemArguments {
  std::string folder;
  bool quiet = false;
  bool json = false;
  bool verbose = false;
  bool realtime = false;
};

/// The loop of the command line; null where there is nothing to simulate: the reason is reported.
std::unique_ptr<LoopTask> task_of(const MpcArguments& arguments, Diagnostics& out) {
  auto spec = read_problem_of(arguments, out);
  return spec ? build_loop(*std::move(spec), {.drop = arguments.drop}, out) : nullptr;
}

std::filesystem::path output_folder(const MpcArguments& arguments, const ProblemSpec& spec) {
  if (arguments.folder.empty()) return std::filesystem::path("out") / spec.name.value;
  return arguments.folder;
}

/// The share of values that `percent` of them do not exceed, ms.
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

std::string summary(const LoopRun& run, const std::vector<std::filesystem::path>& written) {
  const ClosedLoopResult& result = run.result;
  const auto failed =
      static_cast<std::ptrdiff_t>(result.ticks.size()) - count_of(result, TickOutcome::planned);
  std::string text =
      fmt::format("{}: {} at {:g} s of {:g} s\n", run.task.spec->name.value, to_string(result.end),
                  result.end_time, run.task.mpc.loop.duration);
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

int exit_code(LoopEnd end) {
  if (end == LoopEnd::finished) return kExitConverged;
  if (end == LoopEnd::interrupted && InterruptGuard::signal() != 0)
    return kExitSignalBase + InterruptGuard::signal();
  return kExitNotConverged;
}

/// s
double wall_clock() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double>(now).count();
}

int simulate_file(const MpcArguments& arguments) {
  Diagnostics diagnostics;
  const auto task = task_of(arguments, diagnostics);
  const auto verbosity = arguments.quiet     ? Verbosity::kQuiet
                         : arguments.verbose ? Verbosity::kVerbose
                                             : Verbosity::kNormal;
  print_messages(diagnostics, verbosity);
  if (!task) return kExitBadInput;
  const auto folder = output_folder(arguments, *task->spec);
  create_folder(folder);  // before the work, so that none is in vain
  const InterruptGuard guard;
  task->mpc.loop.interrupted = [] { return InterruptGuard::signal() != 0; };
  if (arguments.realtime) task->mpc.controller.clock = wall_clock;
  const ClosedLoopResult result = run_loop(*task);
  const LoopRun run{*task, result, settings_of(arguments)};
  const auto written = write_loop(run, folder);
  if (arguments.json)
    print_result(json_text(loop_json(run)));
  else if (!arguments.quiet)
    print_result(summary(run, written));
  return exit_code(result.end);
}

/// Which file, and by which solver of windows.
std::vector<Argument> loop_arguments(MpcArguments& arguments) {
  std::vector<Argument> all = problem_arguments(arguments);
  for (Argument& argument : all) {
    if (argument.names.front() != "--solver") continue;
    argument.choices = {std::string(kAutoSolver)};
    for (const DdpMember& member : ddp_family()) argument.choices.emplace_back(member.name);
  }
  return all;
}

}  // namespace

Command mpc_command() {
  const auto a = std::make_shared<MpcArguments>();
  return {.name = "conddp mpc",
          .description = "Simulate model predictive control of a problem file in a closed loop",
          .details =
              "The file's section 'mpc' says how. Writes mpc.json, closed_loop.csv, ticks.csv "
              "and tick_times.csv, all of them or none. Exit status 1 where the loop ended "
              "before its duration.",
          .arguments = joined(
              loop_arguments(*a),
              {{.names = {"-o", "--output"},
                .value = "FOLDER",
                .description = "Folder for the outputs; out/<problem name> if nothing is said",
                .target = &a->folder},
               threads_argument(a->threads, "Threads; results do not depend on it"),
               flag({"--realtime"}, a->realtime,
                    "Measure solves: ticks whose preparation and feedback take longer than a tick "
                    "are late. Outputs then differ from run to run"),
               flag({"--quiet"}, a->quiet, "Print nothing but errors"),
               flag({"--json"}, a->json, "Print mpc.json on stdout"),
               flag({"-v", "--verbose"}, a->verbose, "Print notes too", "--quiet")}),
          .run = [a] { return simulate_file(*a); }};
}

}  // namespace conddp
