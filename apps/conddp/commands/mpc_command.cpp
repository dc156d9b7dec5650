#include <filesystem>
#include <memory>

#include "arguments/shared_arguments.hpp"
#include "base/files/atomic_file.hpp"
#include "base/json/ordered_json.hpp"
#include "commands/closed_loops.hpp"
#include "commands/commands.hpp"
#include "output/report/loop_report.hpp"
#include "summary/summary.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/streams.hpp"

namespace conddp {
namespace {

int exit_code(LoopEnd end) {
  if (end == LoopEnd::finished) return kExitConverged;
  if (end == LoopEnd::interrupted && InterruptGuard::signal() != 0)
    return kExitSignalBase + InterruptGuard::signal();
  return kExitNotConverged;
}

/// Writes a loop and prints its summary.
void put_out(const MpcArguments& arguments, const LoopRun& run,
             const std::filesystem::path& folder) {
  const auto written = write_loop(run, folder);
  if (arguments.json)
    print_result(json_text(loop_json(run)));
  else if (!arguments.quiet)
    print_result(loop_summary(run, written));
}

/// Writes the page of a loop and prints its path.
void write_page(const MpcArguments& arguments, const LoopRun& run,
                const std::vector<RecordedPlan>& plans) {
  AtomicFiles files;
  files.add(arguments.report, report_text(loop_report(run, plans)));
  files.commit();
  if (!arguments.json && !arguments.quiet) print_result(arguments.report + '\n');
}

int simulate_file(const MpcArguments& arguments) {
  if (!arguments.report.empty() && !reports_can_be_made()) return kExitBadInput;
  Diagnostics diagnostics;
  const auto task = build_loop(
      read_problem(load_problem_of(arguments, diagnostics), settings_of(arguments), diagnostics),
      build_options_of(arguments), diagnostics);
  print_messages(diagnostics, verbosity_of(arguments));
  if (!task) return kExitBadInput;
  const auto folder = output_folder(arguments, task->built);
  create_folder(folder);  // so that a failure wastes no work
  if (!arguments.report.empty())
    create_folder(std::filesystem::absolute(arguments.report).parent_path());
  const InterruptGuard guard;
  PlanRecorder recorder(*task);
  const auto record = [&recorder](const Mpc& mpc) { recorder.record(mpc); };
  const ClosedLoopResult result = arguments.report.empty()
                                      ? simulate_task(arguments, *task)
                                      : simulate_task(arguments, *task, record);
  const LoopRun run{*task, result, settings_of(arguments)};
  put_out(arguments, run, folder);
  if (!arguments.report.empty()) write_page(arguments, run, recorder.plans());
  return exit_code(result.end);
}

int run(const MpcArguments& arguments) {
  if (arguments.largest.empty()) return simulate_file(arguments);
  if (arguments.file == kStandardInput) {
    print_error("--largest reads the file again for each value: it cannot be the standard input",
                "name a file");
    return kExitBadInput;
  }
  return search_largest(arguments);
}

}  // namespace

Command mpc_command() {
  const auto a = std::make_shared<MpcArguments>();
  return {
      .name = "conddp mpc",
      .description = "Simulate model predictive control of a problem file in a closed loop",
      .details =
          "The file's section 'mpc' configures the loop. Writes mpc.json, closed_loop.csv, "
          "ticks.csv and tick_times.csv, all of them or none; with --largest, largest.csv too, "
          "after each trial. Exit status 1 if the loop ended before its duration; with --largest, "
          "if the loop fails at LOW.",
      .arguments = joined(
          problem_arguments(*a),
          {{.names = {"-o", "--output"},
            .value = "FOLDER",
            .description = "Folder for the outputs (default: out/<problem name>)",
            .target = &a->folder},
           threads_argument(a->threads, "Threads; results do not depend on it"),
           {.names = {"--report"},
            .value = "FILE.html",
            .description = "Make a page for the browser: the plant in 3-D, the plan of each "
                           "tick as a ghost, events and times of ticks",
            .excludes = "--largest",
            .target = &a->report},
           {.names = {"--largest"},
            .value = "KEY=[LOW,HIGH]",
            .description =
                "Find by bisection the largest value of a key for which the loop lasts for its "
                "duration and satisfies every stop_when condition; largest.csv lists the trials",
            .check = largest_defect,
            .target = &a->largest},
           flag({"--realtime"}, a->realtime,
                "Measure solves: ticks whose preparation and feedback take longer than a tick "
                "are late. Outputs then differ from run to run"),
           flag({"--quiet"}, a->quiet, "Print nothing but errors"),
           flag({"--json"}, a->json,
                "Print mpc.json on stdout; with --largest, what was found is in it"),
           flag({"-v", "--verbose"}, a->verbose, "Print notes too", "--quiet")}),
      .run = [a] { return run(*a); }};
}

}  // namespace conddp
