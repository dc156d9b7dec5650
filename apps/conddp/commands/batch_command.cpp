#include <algorithm>
#include <charconv>
#include <csignal>
#include <filesystem>
#include <optional>
#include <thread>

#include <unistd.h>

#include <fmt/format.h>

#include "base/atomic_file.hpp"
#include "base/json_text.hpp"
#include "base/relative_paths.hpp"
#include "base/strict_number.hpp"
#include "batch/plan/expand_plan.hpp"
#include "batch/plan/run_folder.hpp"
#include "batch/results/collect.hpp"
#include "batch/run/run_batch.hpp"
#include "batch/run/worker.hpp"
#include "commands/batch_worker.hpp"
#include "commands/commands.hpp"
#include "problem_file/build/build_problem.hpp"
#include "problem_file/expand/expand_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "problem_file/yaml/yaml_text.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/messages.hpp"
#include "terminal/status_line.hpp"
#include "terminal/streams.hpp"
#include "terminal/terminal.hpp"

namespace conddp {
namespace {

namespace fs = std::filesystem;

struct BatchArguments {
  std::string action, path, word;
  std::string folder;
  int jobs = 0;
  int group = 8;
  int pilot = 0;
  std::string shard, budget;
  bool any_build = false;
};

constexpr std::string_view kFailed = "failed", kTimeout = "timeout";

// ---- signals

volatile std::sig_atomic_t g_batch_signal = 0;
volatile std::sig_atomic_t g_batch_stop = 0;

extern "C" void remember_batch_signal(int number) { g_batch_signal = number; }
extern "C" void remember_batch_stop(int) { g_batch_stop = 1; }

/// A second signal of the same kind ends the process at once; results are whole lines all the same.
void handle_signals() {
  struct sigaction action {};
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESETHAND;
  action.sa_handler = remember_batch_signal;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  action.sa_flags = 0;
  action.sa_handler = remember_batch_stop;
  sigaction(SIGUSR1, &action, nullptr);
}

// ---- arguments

/// "2/7"
std::optional<Shard> parse_shard(const std::string& text) {
  const char* end = text.data() + text.size();
  Shard shard;
  const auto first = std::from_chars(text.data(), end, shard.index);
  if (first.ec != std::errc() || first.ptr == end || *first.ptr != '/') return std::nullopt;
  const auto second = std::from_chars(first.ptr + 1, end, shard.count);
  if (second.ec != std::errc() || second.ptr != end) return std::nullopt;
  if (shard.index < 1 || shard.index > shard.count) return std::nullopt;
  --shard.index;
  return shard;
}

/// "90", "90s", "55m", "2h" in seconds.
std::optional<double> parse_duration(std::string text) {
  double unit = 1;
  if (text.ends_with('h')) unit = 3600;
  if (text.ends_with('m')) unit = 60;
  if (text.ends_with('h') || text.ends_with('m') || text.ends_with('s')) text.pop_back();
  const auto number = parse_number(text).value;
  if (!number || *number <= 0) return std::nullopt;
  return *number * unit;
}

template <class Parse>
ArgumentCheck parsed_by(Parse parse, const std::string& expected) {
  return [=](const std::string& text) {
    return parse(text) ? std::string() : fmt::format("'{}' is not {}", text, expected);
  };
}

int give_up(const Diagnostics& diagnostics) {
  print_messages(diagnostics, Verbosity::kVerbose);
  return kExitBadInput;
}

// ---- actions

std::string time_words(double seconds) {
  if (seconds < 90) return fmt::format("{:.0f} s", seconds);
  if (seconds < 5400) return fmt::format("{:.0f} min", seconds / 60);
  return fmt::format("{:.1f} h", seconds / 3600);
}

std::string size_words(double bytes) {
  if (bytes < 1e6) return fmt::format("{:.0f} kB", std::max(1.0, bytes / 1e3));
  if (bytes < 1e9) return fmt::format("{:.0f} MB", bytes / 1e6);
  return fmt::format("{:.1f} GB", bytes / 1e9);
}

std::vector<std::string> worker_command(const fs::path& run) {
  return {fs::read_symlink("/proc/self/exe").string(), std::string(kBatchWorker), run.string()};
}

int exit_code(const BatchProgress& progress) {
  if (g_batch_signal != 0) return kExitSignalBase + g_batch_signal;
  return progress.failed == 0 && progress.before + progress.done == progress.items
             ? kExitConverged
             : kExitNotConverged;
}

std::string progress_words(const BatchProgress& p) {
  const double rate = p.done / std::max(p.elapsed_s, 1e-9);
  const std::size_t left = p.items - p.before - p.done;
  std::string words = fmt::format("{} of {}", p.before + p.done, p.items);
  if (p.failed > 0) words += fmt::format(", {} failed", p.failed);
  if (p.done > 0)
    words += fmt::format(", {:.3g} items/s, about {} left", rate, time_words(left / rate));
  return words;
}

BatchProgress run_items(const fs::path& run, const Manifest& manifest, BatchOptions options) {
  handle_signals();
  StatusLine status(message_format() == MessageFormat::kText && terminal_of(2).redraws);
  options.worker_command = worker_command(run);
  options.interrupted = [] { return g_batch_signal != 0; };
  options.stop_soon = [] { return g_batch_stop != 0; };
  options.on_progress = [&](const BatchProgress& p) { status.show(progress_words(p)); };
  return run_batch(run, manifest, options);
}

BatchOptions options_of(const BatchArguments& arguments) {
  BatchOptions options{.workers = arguments.jobs, .group = arguments.group};
  if (options.workers == 0)
    options.workers = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  if (!arguments.shard.empty()) options.shard = *parse_shard(arguments.shard);
  if (!arguments.budget.empty()) options.budget_s = *parse_duration(arguments.budget);
  return options;
}

std::string summary(const BatchProgress& p) {
  std::string text = fmt::format("{} of {} items have a result, {} of them solved",
                                 p.before + p.done, p.items, p.before + p.done - p.failed);
  if (p.done > 0)
    text += fmt::format("; {} in {:.3g} s ({:.3g} items/s)", p.done, p.elapsed_s,
                        p.done / std::max(p.elapsed_s, 1e-9));
  return text + '\n';
}

/// Solves a few items, spread over all, and says what the others will take.
int run_pilot(const fs::path& run, const Manifest& manifest, const BatchArguments& arguments) {
  BatchOptions options = options_of(arguments);
  const std::size_t count = manifest.items.size();
  const std::size_t wanted = std::min<std::size_t>(count, arguments.pilot);
  options.only.emplace();
  for (std::size_t i = 0; i < wanted; ++i) options.only->push_back(i * count / wanted);
  const BatchProgress progress = run_items(run, manifest, options);
  if (g_batch_signal != 0) return kExitSignalBase + g_batch_signal;
  const auto results = load_results(run);
  double seconds = 0, bytes = 0, solved = 0;
  for (const std::size_t item : *options.only)
    if (const auto found = results.find(manifest.items[item].id); found != results.end()) {
      seconds += found->second.result.times.value("all", 0.0);
      bytes += static_cast<double>(found->second.result.solution_bytes);
      solved += found->second.result.success;
    }
  const double scale = static_cast<double>(count) / static_cast<double>(wanted);
  print_result(
      fmt::format("pilot: {:.0f} of {} solved; all {} items take about {} with {} workers, and {} "
                  "of solutions\n",
                  solved, wanted, count, time_words(seconds * scale / options.workers),
                  options.workers, size_words(bytes * scale)));
  return exit_code(progress);
}

/// The manifest of a plan, written into the folder of its run.
std::optional<Manifest> make_plan(const BatchArguments& arguments, fs::path& run,
                                  Diagnostics& out) {
  const auto plan = load_batch_plan(arguments.path, out);
  if (!plan) return std::nullopt;
  run = arguments.folder.empty() ? fs::path("out") / plan->name.value : fs::path(arguments.folder);
  auto manifest = expand_plan(*plan, run, out);
  if (!manifest) return std::nullopt;
  write_run_folder(*plan, *manifest, run, out);
  if (out.has_errors()) return std::nullopt;
  return manifest;
}

int plan_batch(const BatchArguments& arguments) {
  Diagnostics diagnostics;
  fs::path run;
  const auto manifest = make_plan(arguments, run, diagnostics);
  if (!manifest) return give_up(diagnostics);
  print_messages(diagnostics, Verbosity::kNormal);
  std::error_code error;
  const fs::space_info space = fs::space(run, error);
  print_result(fmt::format("{} items in '{}', of {} problem file{}\n", manifest->items.size(),
                           run.string(), manifest->problems.size(),
                           manifest->problems.size() == 1 ? "" : "s"));
  if (!error)
    print_result(
        fmt::format("{} are free there\n", size_words(static_cast<double>(space.available))));
  return arguments.pilot > 0 ? run_pilot(run, *manifest, arguments) : kExitConverged;
}

void write_tables(const fs::path& run, const Manifest& manifest) {
  const auto results = load_results(run);
  AtomicFiles files;
  files.add(run / "results.csv", results_csv(manifest, results));
  files.add(run / "times.csv", times_csv(manifest, results));
  files.commit();
}

int run_plan_or_folder(const BatchArguments& arguments) {
  Diagnostics diagnostics;
  fs::path run = arguments.path;
  std::error_code error;
  const bool is_folder = fs::is_directory(run, error);
  auto manifest =
      is_folder ? load_manifest(run, true, diagnostics) : make_plan(arguments, run, diagnostics);
  if (!manifest || !fits_run_folder(*manifest, run, arguments.any_build, diagnostics))
    return give_up(diagnostics);
  print_messages(diagnostics, Verbosity::kNormal);
  const BatchProgress progress = run_items(run, *manifest, options_of(arguments));
  if (!is_folder) write_tables(run, *manifest);
  print_result(summary(progress));
  return exit_code(progress);
}

/// The manifest of the folder that the command line names; without one the exit status.
std::optional<Manifest> manifest_of(const BatchArguments& arguments) {
  Diagnostics diagnostics;
  auto manifest = load_manifest(arguments.path, true, diagnostics);
  if (!manifest) print_messages(diagnostics, Verbosity::kNormal);
  return manifest;
}

int show_status(const BatchArguments& arguments) {
  const auto manifest = manifest_of(arguments);
  if (!manifest) return kExitBadInput;
  const BatchStatus status = batch_status(*manifest, load_results(arguments.path));
  std::string text = fmt::format("{}: {} items, {} solved, {} unfinished\n", manifest->name,
                                 status.items, status.solved, status.unfinished);
  for (const auto& [name, count] : status.by_status)
    text += fmt::format("  {:<20}{}\n", name, count);
  const std::size_t done = status.items - status.unfinished;
  if (done > 0 && status.unfinished > 0)
    text += fmt::format("the unfinished take about {} of one worker\n",
                        time_words(status.solve_s / done * status.unfinished));
  print_result(text);
  return status.solved == status.items ? kExitConverged : kExitNotConverged;
}

int collect_results(const BatchArguments& arguments) {
  const auto manifest = manifest_of(arguments);
  if (!manifest) return kExitBadInput;
  write_tables(arguments.path, *manifest);
  const BatchStatus status = batch_status(*manifest, load_results(arguments.path));
  print_result(fmt::format("{} of {} items in '{}'\n", status.items - status.unfinished,
                           status.items, (fs::path(arguments.path) / "results.csv").string()));
  return kExitConverged;
}

/// Solves items that failed once more.
int retry_items(const BatchArguments& arguments) {
  Diagnostics diagnostics;
  const fs::path run = arguments.path;
  const auto manifest = load_manifest(run, true, diagnostics);
  if (!manifest || !fits_run_folder(*manifest, run, arguments.any_build, diagnostics))
    return give_up(diagnostics);
  BatchOptions options = options_of(arguments);
  options.only =
      failed_items(*manifest, load_results(run),
                   arguments.word == kTimeout ? FailureKind::kTimeout : FailureKind::kAny);
  options.again = true;
  const BatchProgress progress = run_items(run, *manifest, options);
  print_result(summary(progress));
  return exit_code(progress);
}

/// Writes the files of one item: its problem with every default, and its solution.
int show_item(const BatchArguments& arguments) {
  const fs::path run = arguments.path;
  const auto manifest = manifest_of(arguments);
  if (!manifest) return kExitBadInput;
  const auto item = std::find_if(manifest->items.begin(), manifest->items.end(),
                                 [&](const auto& i) { return i.id == arguments.word; });
  if (item == manifest->items.end()) {
    print_error(fmt::format("'{}' has no item '{}'", run.string(), arguments.word),
                "the ids are in its results.csv and manifest.jsonl");
    return kExitBadInput;
  }
  Diagnostics diagnostics;
  const fs::path file = problem_of_run(*manifest, item->problem, run);
  const auto spec = read_problem(file, item->settings, diagnostics);
  const auto built = spec ? build_problem(*spec, {}, diagnostics) : std::nullopt;
  if (!built) return give_up(diagnostics);
  const fs::path folder =
      arguments.folder.empty() ? run / "items" / item->id : fs::path(arguments.folder);
  OrderedJson problem = expand_problem(*spec, *built);
  make_paths_relative(problem, file.parent_path(), folder);
  const auto results = load_results(run);
  const auto stored = results.find(item->id);
  const std::string solution = stored == results.end() || stored->second.result.solution_bytes == 0
                                   ? std::string()
                                   : load_solution(stored->second);
  create_folder(folder);
  AtomicFiles files;
  if (!solution.empty()) {
    OrderedJson document = OrderedJson::parse(solution);
    document["problem"]["file"] = file.string();
    files.add(folder / "solution.json", json_text(document));
  }
  files.add(folder / "problem.yaml", yaml_text(problem));
  files.commit();
  print_result(fmt::format("{}: {}\n{}\n", item->id,
                           stored == results.end() ? kUnfinished : stored->second.result.status,
                           (folder / "problem.yaml").string()));
  if (!solution.empty()) print_result((folder / "solution.json").string() + '\n');
  return kExitConverged;
}

/// What the words of the command line lack or have too much of, empty if they fit.
std::string misuse(const BatchArguments& arguments) {
  const bool retries = arguments.action == "retry", shows = arguments.action == "show";
  if (retries && arguments.word != kFailed && arguments.word != kTimeout)
    return "say what to solve again: 'failed' or 'timeout'";
  if (shows && arguments.word.empty()) return "say which item to show: its id";
  if (!retries && !shows && !arguments.word.empty())
    return fmt::format("'{}' is too much: '{}' takes one path", arguments.word, arguments.action);
  return {};
}

int batch(const BatchArguments& arguments) {
  if (const std::string text = misuse(arguments); !text.empty()) {
    print_error(text, "'conddp batch --help' lists what it takes");
    return kExitBadInput;
  }
  if (arguments.action == "plan") return plan_batch(arguments);
  if (arguments.action == "run") return run_plan_or_folder(arguments);
  if (arguments.action == "status") return show_status(arguments);
  if (arguments.action == "retry") return retry_items(arguments);
  if (arguments.action == "show") return show_item(arguments);
  return collect_results(arguments);
}

}  // namespace

int batch_worker(const char* run) {
  const int answers = ::dup(1);
  ::dup2(2, 1);  // what a library prints is no answer
  return serve_items(run, 0, answers);
}

Command batch_command() {
  const auto a = std::make_shared<BatchArguments>();
  return {
      .name = "conddp batch",
      .description = "Solve many problems that differ in a few values",
      .details =
          "plan PLAN.yaml   checks every item of a plan and writes the folder of a run\n"
          "run RUN          solves the items that have no result yet; run PLAN.yaml does all at "
          "once\n"
          "status RUN       counts results\n"
          "collect RUN      writes results.csv and times.csv\n"
          "retry RUN failed|timeout   solves again what was not solved\n"
          "show RUN ID      writes the problem and the solution of one item\n"
          "Every worker is a process of its own; ending one, or all, loses no more than the items "
          "under way. Exit status 0: all items are solved; 1: some are not, or have no result yet.",
      .arguments =
          {{.names = {"ACTION"},
            .value = "ACTION",
            .description = "What to do",
            .choices = {"plan", "run", "status", "collect", "retry", "show"},
            .required = true,
            .target = &a->action},
           {.names = {"PATH"},
            .value = "PATH.yaml",
            .description = "Plan, or the folder of a run",
            .required = true,
            .target = &a->path},
           {.names = {"WORD"},
            .value = "WORD",
            .description = "retry: failed or timeout; show: the id of an item",
            .target = &a->word},
           {.names = {"-o", "--output"},
            .value = "FOLDER",
            .description =
                "Folder of the run that a plan makes (out/<its name>), or of what show writes",
            .target = &a->folder},
           {.names = {"-j", "--jobs"},
            .value = "N",
            .description = "Worker processes; one a processor if nothing is said",
            .numbers = WholeNumbers{1, 1024},
            .target = &a->jobs},
           {.names = {"--group"},
            .value = "N",
            .description = "Items that are sent to a worker ahead",
            .numbers = WholeNumbers{1, 1000},
            .fallback = std::to_string(a->group),
            .target = &a->group},
           {.names = {"--pilot"},
            .value = "N",
            .description = "plan: solve this many items, and estimate the rest",
            .numbers = WholeNumbers{1, 100000},
            .target = &a->pilot},
           {.names = {"--shard"},
            .value = "I/N",
            .description = "run: solve one share of the items, such as 2/7",
            .check = parsed_by(parse_shard, "a share such as 2/7"),
            .target = &a->shard},
           {.names = {"--budget"},
            .value = "TIME",
            .description = "run: begin no item after this time: 90s, 55m, 2h",
            .check = parsed_by(parse_duration, "a time such as 90s, 55m or 2h"),
            .target = &a->budget},
           flag({"--any-build"}, a->any_build,
                "run: go on where another build of conddp made the plan")},
      .run = [a] { return batch(*a); }};
}

}  // namespace conddp
