#include <algorithm>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "arguments/problem_arguments.hpp"
#include "arguments/shared_arguments.hpp"
#include "base/files/atomic_file.hpp"
#include "base/json/json_text.hpp"
#include "base/text/csv_line.hpp"
#include "base/text/strict_number.hpp"
#include "commands/commands.hpp"
#include "mpc/largest_survived.hpp"
#include "output/mpc/loop_files.hpp"
#include "output/report/loop_report.hpp"
#include "output/solution/csv_cells.hpp"
#include "solvers/ddp/family.hpp"
#include "solvers/strategies/registry.hpp"
#include "summary/report_file.hpp"
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
  std::string largest;
  std::string report;
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

Verbosity verbosity_of(const MpcArguments& arguments) {
  if (arguments.quiet) return Verbosity::kQuiet;
  return arguments.verbose ? Verbosity::kVerbose : Verbosity::kNormal;
}

/// Simulates a loop until its end or a signal.
ClosedLoopResult simulate_task(const MpcArguments& arguments, LoopTask& task,
                               std::function<void(const Mpc&)> observe = nullptr) {
  task.mpc.loop.interrupted = [] { return InterruptGuard::signal() != 0; };
  if (arguments.realtime) task.mpc.controller.clock = wall_clock;
  return run_loop(task, std::move(observe));
}

/// Writes a loop and says so.
void put_out(const MpcArguments& arguments, const LoopRun& run,
             const std::filesystem::path& folder) {
  const auto written = write_loop(run, folder);
  if (arguments.json)
    print_result(json_text(loop_json(run)));
  else if (!arguments.quiet)
    print_result(summary(run, written));
}

/// Makes the page of a loop and says where it is.
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
  const auto task = task_of(arguments, diagnostics);
  print_messages(diagnostics, verbosity_of(arguments));
  if (!task) return kExitBadInput;
  const auto folder = output_folder(arguments, *task->spec);
  create_folder(folder);  // before the work, so that none is in vain
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

/// A number of the file, and between what its largest value that is survived is looked for.
struct SearchedNumber {
  std::string key;
  double low = 0, high = 0;
};

/// Reads "KEY=[LOW, HIGH]"; nothing where it is not that.
std::optional<SearchedNumber> parse_searched(const std::string& text) {
  const std::size_t open = text.find("=["), comma = text.find(',', open);
  if (open == 0 || open == std::string::npos || comma == std::string::npos || !text.ends_with(']'))
    return std::nullopt;
  const auto number = [&](std::size_t from, std::size_t to) {
    return parse_number(trimmed_csv(std::string_view(text).substr(from, to - from))).value;
  };
  const auto low = number(open + 2, comma), high = number(comma + 1, text.size() - 1);
  if (!low || !high || *low >= *high) return std::nullopt;
  return SearchedNumber{text.substr(0, open), *low, *high};
}

std::string searched_defect(const std::string& text) {
  if (parse_searched(text)) return {};
  return fmt::format(
      "'{}' is not KEY=[LOW, HIGH], a key of the file and two numbers, the lower one first", text);
}

/// Looks for the largest value of a number whose loop lasts.
class Search {
 public:
  Search(const MpcArguments& arguments, SearchedNumber number)
      : arguments_(arguments), number_(std::move(number)) {}

  int run() {
    const InterruptGuard guard;
    const double width = (number_.high - number_.low) / kParts;
    const auto largest = largest_survived(number_.low, number_.high, width,
                                          [this](double value) { return survives(value); });
    print_messages(diagnostics_, verbosity_of(arguments_));
    if (diagnostics_.has_errors()) return kExitBadInput;
    if (InterruptGuard::signal() != 0) return kExitSignalBase + InterruptGuard::signal();
    write(largest);
    return largest ? kExitConverged : kExitNotConverged;
  }

 private:
  /// What is left of the range at the end is this part of it.
  static constexpr int kParts = 128;

  struct Trial {
    MpcArguments arguments;
    std::unique_ptr<LoopTask> task;
    ClosedLoopResult result;
  };

  bool survives(double value) {
    if (diagnostics_.has_errors() || InterruptGuard::signal() != 0) return false;
    Trial trial{.arguments = arguments_};
    trial.arguments.settings.push_back(fmt::format("{}={}", number_.key, value));
    Diagnostics own;
    trial.task = task_of(trial.arguments, own);
    if (!trial.task || rows_.empty()) diagnostics_ = std::move(own);
    if (!trial.task) return false;
    trial.result = simulate_task(trial.arguments, *trial.task);
    const bool survived = trial.result.end == LoopEnd::finished;
    rows_ += fmt::format("{},{},{}", value, survived ? 1 : 0, to_string(trial.result.end));
    for (const double figure :
         {tabulated_time(trial.result.end_time), trial.result.cost, trial.result.violation}) {
      rows_ += ',';
      append_cell(figure, rows_);
    }
    rows_ += '\n';
    if (survived || !shown_.task) shown_ = std::move(trial);
    return survived;
  }

  /// The trials, and the files of the largest one that lasted; of the first one if none did.
  void write(const std::optional<double>& largest) const {
    const auto folder = output_folder(arguments_, *shown_.task->spec);
    create_folder(folder);
    AtomicFiles files;
    files.add(folder / kTrialsFile,
              csv_cell(number_.key) + ",survived,end,time_s,cost,violation\n" + rows_);
    files.commit();
    if (!arguments_.json && !arguments_.quiet) print_result(line_of(largest));
    put_out(arguments_, {*shown_.task, shown_.result, settings_of(shown_.arguments)}, folder);
  }

  std::string line_of(const std::optional<double>& largest) const {
    if (!largest) return fmt::format("{} is not survived at {}\n", number_.key, number_.low);
    return fmt::format("{} is survived up to {}{}\n", number_.key, *largest,
                       *largest == number_.high ? ", all of the range" : "");
  }

  static constexpr const char* kTrialsFile = "largest.csv";

  const MpcArguments& arguments_;
  const SearchedNumber number_;
  Diagnostics diagnostics_;
  std::string rows_;  ///< of the trials
  Trial shown_;       ///< whose files are written
};

int run(const MpcArguments& arguments) {
  if (arguments.largest.empty()) return simulate_file(arguments);
  if (arguments.file == kStandardInput) {
    print_error("--largest reads the file again for each value: it cannot be the standard input",
                "name a file");
    return kExitBadInput;
  }
  return Search(arguments, *parse_searched(arguments.largest)).run();
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
               {.names = {"--report"},
                .value = "FILE.html",
                .description = "Make a page for the browser: the plant in 3-D, the plan of each "
                               "tick as a ghost, events and times of ticks",
                .excludes = "--largest",
                .target = &a->report},
               {.names = {"--largest"},
                .value = "KEY=[LOW,HIGH]",
                .description = "Look by bisection for the largest number of a key of the file "
                               "whose loop lasts for its duration; largest.csv has the trials",
                .check = searched_defect,
                .target = &a->largest},
               flag({"--realtime"}, a->realtime,
                    "Measure solves: ticks whose preparation and feedback take longer than a tick "
                    "are late. Outputs then differ from run to run"),
               flag({"--quiet"}, a->quiet, "Print nothing but errors"),
               flag({"--json"}, a->json, "Print mpc.json on stdout"),
               flag({"-v", "--verbose"}, a->verbose, "Print notes too", "--quiet")}),
          .run = [a] { return run(*a); }};
}

}  // namespace conddp
