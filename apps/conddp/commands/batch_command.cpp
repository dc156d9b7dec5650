#include <algorithm>
#include <csignal>
#include <filesystem>
#include <thread>

#include <unistd.h>

#include <fmt/format.h>

#include "arguments/batch_arguments.hpp"
#include "base/files/atomic_file.hpp"
#include "base/shared_library.hpp"
#include "base/text/spelling.hpp"
#include "batch/cluster/array_index.hpp"
#include "batch/plan/expand_plan.hpp"
#include "batch/plan/neighbours.hpp"
#include "batch/plan/run_folder.hpp"
#include "batch/plan/spread.hpp"
#include "batch/results/collect.hpp"
#include "batch/results/dataset.hpp"
#include "batch/run/run_batch.hpp"
#include "batch/run/worker.hpp"
#include "commands/batch_actions.hpp"
#include "commands/commands.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/messages.hpp"
#include "terminal/status_line.hpp"
#include "terminal/streams.hpp"
#include "terminal/terminal.hpp"

namespace conddp {
namespace {

namespace fs = std::filesystem;

volatile std::sig_atomic_t g_batch_signal = 0;
volatile std::sig_atomic_t g_batch_stop = 0;

extern "C" void remember_batch_signal(int number) { g_batch_signal = number; }
extern "C" void remember_batch_stop(int) { g_batch_stop = 1; }

/// A second signal of the same kind ends the process at once; results still consist of whole lines.
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

int give_up(const Diagnostics& diagnostics) {
  print_messages(diagnostics, Verbosity::kVerbose);
  return kExitBadInput;
}

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
  std::vector<std::string> words = {fs::read_symlink("/proc/self/exe").string(),
                                    std::string(kBatchWorker), run.string()};
  if (code_is_allowed()) words.emplace_back(kAllowCode);
  return words;
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

/// The shard of --shard; reports an error if neither the environment nor the plan determines it.
std::optional<Shard> shard_of(const BatchArguments& arguments, const Manifest& manifest,
                              Diagnostics& out) {
  if (arguments.shard.empty()) return Shard();
  const ShardWords words = *parse_shard(arguments.shard);
  Shard shard{words.index.value_or(0), words.count.value_or(manifest.shards)};
  if (words.index) return shard;
  const auto array = array_index();
  if (!array) {
    out.error({}, "--shard auto has no index: this process is not part of a job array",
              "the variables looked for are " + array_index_variables());
    return std::nullopt;
  }
  if (!array->index) {
    out.error({}, fmt::format("{} is '{}', which is not an index", array->variable, array->text),
              "a whole number from 0 is expected; --shard I/N sets the index directly");
    return std::nullopt;
  }
  shard.index = *array->index;
  if (shard.index < shard.count) return shard;
  out.error({},
            fmt::format("{} is {}, and there are {} shards, counted from 0", array->variable,
                        shard.index, shard.count),
            "give their number: --shard auto/N, or --shards N when the plan is made");
  return std::nullopt;
}

/// Options of a batch run; reports an undetermined shard.
std::optional<BatchOptions> options_of(const BatchArguments& arguments, const Manifest& manifest,
                                       Diagnostics& out) {
  const auto shard = shard_of(arguments, manifest, out);
  if (!shard) return std::nullopt;
  BatchOptions options{.workers = arguments.jobs, .group = arguments.group, .shard = *shard};
  if (options.workers == 0)
    options.workers = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  if (!arguments.budget.empty()) options.budget_s = *parse_duration(arguments.budget);
  return options;
}

std::string summary(const BatchProgress& p, const Manifest& manifest) {
  std::string text = fmt::format("{} of {} {} a result, {} of them {}", p.before + p.done,
                                 counted(p.items, "item"), p.items == 1 ? "has" : "have",
                                 p.before + p.done - p.failed, success_word(manifest.command));
  if (p.done > 0)
    text += fmt::format("; {} in {:.3g} s ({:.3g} items/s)", p.done, p.elapsed_s,
                        p.done / std::max(p.elapsed_s, 1e-9));
  return text + '\n';
}

/// A note that a run's tables are older than its results; empty if they are current or missing.
std::string stale_tables(const fs::path& run, const BatchProgress& p) {
  std::error_code error;
  if (p.done == 0 || !fs::exists(run / "results.csv", error)) return {};
  return fmt::format("'{}' is older than these results: 'conddp batch collect' writes it again\n",
                     (run / "results.csv").string());
}

/// Solves a few items, spread over all, and estimates the time of the others.
int run_pilot(const fs::path& run, const Manifest& manifest, const BatchArguments& arguments) {
  Diagnostics diagnostics;
  auto wanted_options = options_of(arguments, manifest, diagnostics);
  if (!wanted_options) return give_up(diagnostics);
  BatchOptions& options = *wanted_options;
  const std::size_t count = manifest.items.size();
  const std::size_t wanted = std::min<std::size_t>(count, arguments.pilot);
  options.only = spread_over(count, wanted);
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
  // Closed loops keep no solutions.
  const std::string space = manifest.command == BatchCommand::kMpc
                                ? std::string()
                                : fmt::format(", and {} of solutions", size_words(bytes * scale));
  print_result(fmt::format("pilot: {:.0f} of {} {}; all {} take about {} with {}{}\n", solved,
                           wanted, success_word(manifest.command), counted(count, "item"),
                           time_words(seconds * scale / options.workers),
                           counted(options.workers, "worker"), space));
  return exit_code(progress);
}

/// The manifest of a plan; writes it into the folder of its run.
std::optional<Manifest> make_plan(const BatchArguments& arguments, fs::path& run,
                                  Diagnostics& out) {
  const auto plan = load_batch_plan(arguments.path, out);
  if (!plan) return std::nullopt;
  run = arguments.folder.empty() ? fs::path("out") / plan->name.value : fs::path(arguments.folder);
  auto manifest = expand_plan(*plan, run, out);
  if (!manifest) return std::nullopt;
  if (arguments.shards > 0) manifest->shards = arguments.shards;
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
  print_result(fmt::format("{} in '{}', of {}\n", counted(manifest->items.size(), "item"),
                           run.string(), counted(manifest->problems.size(), "problem file")));
  if (!error)
    print_result(
        fmt::format("{} are free there\n", size_words(static_cast<double>(space.available))));
  return arguments.pilot > 0 ? run_pilot(run, *manifest, arguments) : kExitConverged;
}

/// The reason for a missing data set; empty if it exists.
std::string why_no_dataset(const fs::path& run, const Manifest& manifest) {
  std::error_code error;
  if (fs::exists(run / "dataset.h5", error)) return {};
  if (manifest.command == BatchCommand::kMpc) return "closed loops have no solutions";
  return manifest.keep == KeptSolutions::kNone
             ? "the plan keeps no solutions ('keep: {solutions: none}')"
             : "no item has a solution that is kept";
}

void write_tables(const fs::path& run, const Manifest& manifest) {
  const auto results = load_results(run);
  AtomicFiles files;
  files.add(run / "results.csv", results_csv(manifest, results));
  files.add(run / "times.csv", times_csv(manifest, results));
  files.commit();
  if (manifest.command == BatchCommand::kMpc) return;  // keeps no solutions
  const DatasetCount count = write_dataset(run, manifest, results);
  if (count.unreadable == 0) return;
  Diagnostics diagnostics;
  diagnostics.warning(
      {},
      fmt::format("{} cannot be read any more, and {} not in the data set",
                  counted(count.unreadable, "solution"), count.unreadable == 1 ? "is" : "are"),
      "'conddp batch retry RUN failed' solves these items again");
  print_messages(diagnostics, Verbosity::kNormal);
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
  if (is_folder && arguments.shards > 0)
    diagnostics.error({}, "the plan of this run fixes the number of shards",
                      "use --shard I/N for another number");
  if (is_folder && !arguments.folder.empty())
    diagnostics.error({}, "-o applies only to a plan: a run stays in its folder");
  const auto options = options_of(arguments, *manifest, diagnostics);
  if (!options || diagnostics.has_errors()) return give_up(diagnostics);
  if (options->budget_s > 0) warn_without_time_limit(*manifest, run, diagnostics);
  print_messages(diagnostics, Verbosity::kNormal);
  const BatchProgress progress = run_items(run, *manifest, *options);
  print_result(summary(progress, *manifest) + (is_folder ? stale_tables(run, progress) : ""));
  if (!is_folder) write_tables(run, *manifest);
  return exit_code(progress);
}

/// The manifest of the folder on the command line; prints errors if it cannot be loaded.
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
  std::string text =
      fmt::format("{}: {}, {} {}, {} unfinished\n", manifest->name, counted(status.items, "item"),
                  status.solved, success_word(manifest->command), status.unfinished);
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
  print_result(fmt::format("{} of {} in '{}'\n", status.items - status.unfinished,
                           counted(status.items, "item"),
                           (fs::path(arguments.path) / "results.csv").string()));
  if (const std::string why = why_no_dataset(arguments.path, *manifest); !why.empty())
    print_result(fmt::format("no dataset.h5: {}\n", why));
  return kExitConverged;
}

/// Solves failed items again, and the items that start from them.
int retry_items(const BatchArguments& arguments) {
  Diagnostics diagnostics;
  const fs::path run = arguments.path;
  const auto manifest = load_manifest(run, true, diagnostics);
  if (!manifest || !fits_run_folder(*manifest, run, arguments.any_build, diagnostics))
    return give_up(diagnostics);
  auto options = options_of(arguments, *manifest, diagnostics);
  if (!options) return give_up(diagnostics);
  const auto kind = arguments.word == kRetryTimeout ? FailureKind::kTimeout : FailureKind::kAny;
  // Items that had to start without the answer of a failed item now start from it.
  options->only = with_descendants(*manifest, failed_items(*manifest, load_results(run), kind));
  options->again = true;
  if (options->only->empty()) {
    print_result("there is nothing to solve again\n");
    return kExitConverged;
  }
  const BatchProgress progress = run_items(run, *manifest, *options);
  print_result(summary(progress, *manifest) + stale_tables(run, progress));
  return exit_code(progress);
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
  if (arguments.action == "report") return report_batch(arguments);
  if (arguments.action == "submit") return submit_batch(arguments);
  return collect_results(arguments);
}

int batch_of_sound_documents(const BatchArguments& arguments) {
  try {
    return batch(arguments);
  } catch (const OrderedJson::exception&) {
    print_error(
        fmt::format("'{}' holds a document in which an entry is missing or has another type",
                    arguments.path),
        "make the plan again, in another folder");
    return kExitBadInput;
  }
}

}  // namespace

int batch_worker(const char* run) {
  const int answers = ::dup(1);
  ::dup2(2, 1);  // output of libraries is not a result
  return serve_items(run, 0, answers);
}

Command batch_command() {
  const auto a = std::make_shared<BatchArguments>();
  return {.name = "conddp batch",
          .description =
              "Solve many problems that differ in a few values, or simulate their closed loops",
          .details = kBatchDetails,
          .arguments = batch_arguments(*a),
          .run = [a] { return batch_of_sound_documents(*a); }};
}

}  // namespace conddp
