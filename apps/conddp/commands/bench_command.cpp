#include <algorithm>
#include <atomic>
#include <chrono>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <system_error>
#include <thread>

#include <fmt/format.h>

#include "analysis/comparison/random_instance.hpp"
#include "arguments/example_problems.hpp"
#include "arguments/shared_arguments.hpp"
#include "base/files/atomic_file.hpp"
#include "base/json/ordered_json.hpp"
#include "base/text/shell_words.hpp"
#include "base/text/spelling.hpp"
#include "commands/bench_problems.hpp"
#include "commands/commands.hpp"
#include "output/bench/benchmark_report.hpp"
#include "output/bench/gnuplot.hpp"
#include "problem_file/assemble/homotopy.hpp"
#include "solvers/common/option_table.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/messages.hpp"
#include "terminal/status_line.hpp"
#include "terminal/streams.hpp"
#include "terminal/terminal.hpp"

namespace conddp {
namespace {

struct BenchArguments {
  std::vector<std::string> inputs;
  std::string solvers = "all";
  std::vector<std::string> drop;
  std::vector<std::string> settings;
  std::vector<std::string> tolerances;
  std::vector<std::string> perturbations;
  std::string folder;
  std::optional<int> repeat;  ///< if given, applies to solves of any duration
  int threads = 0;
  int jobs = 1;
  int instances = 1;
  std::uint64_t seed = 1;
  double max_time = 0;
  bool json = false;
};

/// Default number of timed repetitions of a solve.
constexpr int kRepeat = 5;
/// Solves longer than this are timed once by default, s.
constexpr double kLongSolve = 1;
/// Default time limit of each solve of the example problems, s.
constexpr double kExampleTimeLimit = 10;

constexpr const char* kGuess = "guess";

/// The automatic choice as a solver: it supports any problem, because some of its candidates do.
const SolverInfo& auto_solver() {
  static const SolverInfo info{.name = kAutoSolver,
                               .control_bounds = BoundSupport::exact,
                               .constraints = ConstraintSupport::all,
                               .complementarity = true,
                               .concurrent = false};
  return info;
}

const SolverInfo* find_bench_solver(std::string_view name) {
  return name == kAutoSolver ? &auto_solver() : find_solver(name);
}

void check_repeated(const std::vector<const SolverInfo*>& chosen, Diagnostics& out) {
  for (std::size_t i = 0; i < chosen.size(); ++i)
    if (std::find(chosen.begin(), chosen.begin() + i, chosen[i]) != chosen.begin() + i)
      out.error({}, fmt::format("--solvers: '{}' stands twice", chosen[i]->name));
}

std::vector<const SolverInfo*> choose_solvers(const std::string& list, Diagnostics& out) {
  std::vector<const SolverInfo*> chosen;
  std::vector<std::string> names{std::string(kAutoSolver)};
  for (const SolverInfo& info : solvers()) names.emplace_back(info.name);
  for (std::size_t start = 0; start <= list.size();) {
    const std::size_t end = std::min(list.find(',', start), list.size());
    const std::string name = list.substr(start, end - start);
    start = end + 1;
    if (name == kAll) {
      for (const SolverInfo& info : solvers()) chosen.push_back(&info);
    } else if (const SolverInfo* info = find_bench_solver(name)) {
      chosen.push_back(info);
    } else {
      out.error({}, fmt::format("--solvers: unknown solver '{}'", name),
                name_hint(name, names, "solvers"), names);
    }
  }
  check_repeated(chosen, out);
  return chosen;
}

/// Settings from --set and --tolerance for all problems: the answers depend on them.
std::vector<std::string> settings_of(const BenchArguments& arguments) {
  std::vector<std::string> settings = arguments.settings;
  for (const auto& [name, value] : named_numbers(arguments.tolerances))
    settings.push_back(fmt::format("solver.tolerances.{}={}", name, value));
  return settings;
}

/// Options that differ from their defaults, by dotted names.
OrderedJson changed_options(const SolverOptions& options) {
  OrderedJson json = OrderedJson::object();
  for (const OptionInfo& info : option_table()) {
    const OptionValue value = info.get(options);
    if (value != info.default_value())
      std::visit([&](const auto& v) { json[std::string(info.name)] = v; }, value);
  }
  return json;
}

/// Examples: "40 s", "3 min".
std::string about(double seconds) {
  return seconds < 90 ? fmt::format("{:.0f} s", seconds) : fmt::format("{:.0f} min", seconds / 60);
}

/// Examples: "2.5 solves/s", "12 solves/min".
std::string rate(double per_second) {
  return per_second >= 1 ? fmt::format("{:.1f} solves/s", per_second)
                         : fmt::format("{:.1f} solves/min", 60 * per_second);
}

/// Progress and speed of a benchmark, and an estimate of the remaining time at the average speed.
/// Unsupported problems take no time and are not counted.
class BenchProgress {
 public:
  /// `runs`: total number of runs.
  explicit BenchProgress(int runs) : runs_(runs) {}

  /// Counts a finished run.
  void count() { ++done_; }
  /// Example: "3 of 20, about 40 s left, 2.5 solves/s".
  std::string text() const {
    const std::string place = fmt::format("{} of {}", std::min(done_ + 1, runs_), runs_);
    if (done_ == 0) return place;
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
    return fmt::format("{}, about {} left, {}", place,
                       about(elapsed.count() / done_ * (runs_ - done_)),
                       rate(done_ / elapsed.count()));
  }

 private:
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  const int runs_;
  int done_ = 0;
};

/// Calls task(0) … task(count − 1) in up to `threads` threads, including the calling one. Each
/// thread takes the next number; after a task returns false or throws, no further numbers are
/// taken. When all threads have ended, the first exception is rethrown.
void run_tasks(int count, int threads, const std::function<bool(int)>& task) {
  std::atomic<int> next = 0;
  std::mutex mutex;
  std::exception_ptr thrown;
  const auto work = [&] {
    try {
      for (int i; (i = next++) < count;)
        if (!task(i)) next = count;
    } catch (...) {
      next = count;
      const std::lock_guard lock(mutex);
      if (!thrown) thrown = std::current_exception();
    }
  };
  std::vector<std::jthread> others;
  try {
    for (int i = 1; i < std::min(threads, count); ++i) others.emplace_back(work);
  } catch (const std::system_error&) {
    // If no more threads can be created, the existing ones do the work.
  }
  work();
  others.clear();
  if (thrown) std::rethrow_exception(thrown);
}

class Bench {
 public:
  Bench(const BenchArguments& arguments, std::vector<const SolverInfo*> solvers,
        std::deque<BenchProblem>& problems)
      : arguments_(arguments),
        solvers_(std::move(solvers)),
        tasks_(make_tasks(problems)),
        progress_(count_runs()),
        status_(message_format() == MessageFormat::kText && terminal_of(2).redraws) {
    BenchmarkRequest& request = report_.request;
    for (const SolverInfo* solver : solvers_) request.solvers.emplace_back(solver->name);
    request.repeat = arguments.repeat.value_or(kRepeat);
    for (const auto& [name, value] : named_numbers(arguments.perturbations))
      (name == kGuess ? request.guess_spread : request.initial_state_size) = value;
    request.instances = arguments.perturbations.empty() ? 0 : arguments.instances;
    request.seed = arguments.seed;
    request.drop = arguments.drop;
    request.settings = arguments.settings;
    for (const auto& [name, value] : named_numbers(arguments.tolerances))
      request.tolerances[name] = value;
  }

  /// Runs every solver on every instance, concurrently if requested. The order of entries does not
  /// depend on the concurrency.
  void run() {
    std::vector<std::optional<BenchmarkEntry>> entries(tasks_.size());
    run_tasks(static_cast<int>(tasks_.size()), arguments_.jobs, [&](int i) {
      entries[i] = run(tasks_[i]);
      return InterruptGuard::signal() == 0;
    });
    for (auto& entry : entries)
      if (entry) report_.entries.push_back(*std::move(entry));
  }

  /// Returns true if all claims of convergence were confirmed.
  bool finish() {
    status_.erase();
    compare_costs(report_);
    if (!arguments_.folder.empty()) write();
    print_result(arguments_.json ? json_text(benchmark_json(report_))
                                 : benchmark_text(report_, false));
    return all_kept_word(report_);
  }

 private:
  /// A solver and an instance.
  struct Task {
    BenchProblem* problem;
    const BuiltProblem* built;
    const SolverInfo* solver;
    std::optional<std::uint64_t> seed;
  };

  /// All tasks, instance by instance.
  std::vector<Task> make_tasks(std::deque<BenchProblem>& problems) const {
    const bool perturbed = !arguments_.perturbations.empty();
    std::vector<Task> tasks;
    for (BenchProblem& problem : problems)
      for (int i = 0; i < (perturbed ? arguments_.instances : 1); ++i)
        for (const SolverInfo* solver : solvers_)
          tasks.push_back({&problem, &problem.fitting(*solver, arguments_.drop), solver,
                           perturbed ? std::optional(arguments_.seed + i) : std::nullopt});
    return tasks;
  }

  /// Number of solves, without repetitions and unsupported problems.
  int count_runs() const {
    return static_cast<int>(std::count_if(tasks_.begin(), tasks_.end(), [](const Task& task) {
      return !unsupported(*task.solver, *task.built->problem);
    }));
  }

  /// Runs a task; empty after a signal.
  std::optional<BenchmarkEntry> run(const Task& task) {
    show(task);
    const BuiltProblem& built = *task.built;
    const Perturbation perturbation = perturbation_of(*task.problem, task.seed);
    if (!perturbation.any()) return run(task, *built.problem, built.guess, homotopy_path(built));
    const ShootingProblem instance =
        perturb_initial_state(*built.problem, perturbation.initial_state, perturbation.seed);
    return run(
        task, instance, guess_of_instance(instance, built.guess, perturbation),
        perturb_initial_state(homotopy_path(built), perturbation.initial_state, perturbation.seed));
  }

  void show(const Task& task) {
    const std::lock_guard lock(mutex_);
    status_.show(fmt::format("{}, {}{}, {}", progress_.text(), task.built->facts().name.value,
                             task.seed ? fmt::format(" seed {}", *task.seed) : "",
                             task.solver->name));
  }

  /// The file's perturbation with the requested changes.
  Perturbation perturbation_of(const BenchProblem& problem,
                               std::optional<std::uint64_t> seed) const {
    Perturbation perturbation = problem.whole().facts().perturbation;
    const BenchmarkRequest& asked = report_.request;
    perturbation.initial_state = asked.initial_state_size.value_or(perturbation.initial_state);
    perturbation.guess = asked.guess_spread.value_or(perturbation.guess);
    perturbation.seed = seed.value_or(perturbation.seed);
    return perturbation;
  }

  std::optional<BenchmarkEntry> run(const Task& task, const ShootingProblem& instance,
                                    const Trajectory& guess, ProblemPath homotopy) {
    BenchProblem& problem = *task.problem;
    const BuiltProblem& built = *task.built;
    SolverOptions options = built.facts().solver.options;
    options.homotopy = std::move(homotopy);
    options.interrupted = [this] {
      const std::lock_guard lock(mutex_);
      status_.refresh();
      return InterruptGuard::signal() != 0;
    };
    if (task.solver->constraints == ConstraintSupport::all) options.multipliers = built.multipliers;
    BenchmarkEntry entry{.problem = built.facts().name.value,
                         .file = built.facts().file.string(),
                         .sha256 = built.facts().sha256,
                         .problem_sha256 = problem.sha256,
                         .knots = instance.knots(),
                         .states = instance.ndx(),
                         .seed = task.seed,
                         .initial_state = instance.initial_state(),
                         .options = changed_options(options)};
    for (int k = 0; k < instance.knots(); ++k)
      entry.controls = std::max(entry.controls, instance.nu(k));
    if (built.dropped.empty() && instance.initial_state() == built.problem->initial_state())
      entry.best_known = problem.best_known;
    Trajectory answer = guess;
    Repetition repetition{.count = report_.request.repeat};
    if (!arguments_.repeat) repetition.longest_s = kLongSolve;
    {
      // The time of a solver without concurrency does not include waiting for others.
      std::unique_lock alone(alone_, std::defer_lock);
      if (!task.solver->concurrent) alone.lock();
      entry.run = run_benchmark(instance, guess, task.solver->name, options, repetition, &answer);
    }
    if (InterruptGuard::signal() != 0) return std::nullopt;
    if (!entry.run.times.empty()) {
      const std::lock_guard lock(mutex_);
      progress_.count();
    }
    for (const DroppedConstraint& constraint : built.dropped)
      if (!entry.run.times.empty())
        entry.left_out.push_back({constraint.name, violation(constraint, instance, answer)});
    entry.command = command_of(entry, built);
    return entry;
  }

  /// The command line that solves an entry alone. It includes a time limit only if the limit ended
  /// the solve; other answers do not depend on it.
  std::string command_of(const BenchmarkEntry& entry, const BuiltProblem& built) const {
    const BenchmarkRequest& asked = report_.request;
    std::vector<std::string> words = {"conddp", "solve", entry.file, "--solver", entry.run.solver};
    const auto add = [&words](const char* option, std::string value) {
      words.insert(words.end(), {option, std::move(value)});
    };
    for (const DroppedConstraint& constraint : built.dropped) add("--drop", constraint.name);
    for (std::string& setting : settings_of(arguments_)) add("--set", std::move(setting));
    if (asked.initial_state_size)
      add("--perturb", fmt::format("initial_state={}", *asked.initial_state_size));
    if (asked.guess_spread) add("--perturb", fmt::format("guess={}", *asked.guess_spread));
    if (entry.seed) add("--seed", std::to_string(*entry.seed));
    if (entry.run.status == to_string(SolveStatus::time_limit) && arguments_.max_time > 0)
      add("--max-time", fmt::format("{}", arguments_.max_time));
    return shell_line(words);
  }

  void write() {
    const std::filesystem::path folder = arguments_.folder;
    create_folder(folder);
    AtomicFiles files;
    files.add(folder / "bench.json", json_text(benchmark_json(report_)));
    files.add(folder / "bench.csv", benchmark_csv(report_));
    files.add(folder / "bench.md", benchmark_text(report_, true));
    const std::string script = profile_script(report_);
    files.add(folder / "profiles.gnuplot", script);
    if (const GnuplotResult plot = run_gnuplot(script); plot.defect.empty()) {
      files.add(folder / "profiles.svg", plot.output);
    } else {
      Diagnostics diagnostics;
      diagnostics.warning({}, "no profiles.svg: " + plot.defect,
                          "the script profiles.gnuplot draws it");
      print_messages(diagnostics, Verbosity::kNormal);
    }
    files.commit();
  }

  const BenchArguments& arguments_;
  std::vector<const SolverInfo*> solvers_;
  const std::vector<Task> tasks_;
  BenchmarkReport report_;
  std::mutex mutex_;  ///< for progress and status
  std::mutex alone_;  ///< for solvers that run one at a time
  BenchProgress progress_;
  StatusLine status_;
};

/// Without files, selects the examples, with a time limit.
void take_examples(BenchArguments& arguments, Diagnostics& out) {
  const auto folders = example_folders();
  if (folders.empty())
    return out.error({},
                     "there are no example problems: no folder 'problems' with *.yaml here, "
                     "and none installed with conddp",
                     "name problem files, or a folder of them");
  arguments.inputs = {folders.front().string()};
  if (arguments.max_time == 0) arguments.max_time = kExampleTimeLimit;
  out.note({},
           fmt::format("no file given: using the problems of '{}', with a limit of {} s per solve",
                       arguments.inputs.front(), arguments.max_time));
}

int bench(BenchArguments arguments) {
  Diagnostics diagnostics;
  if (arguments.inputs.empty()) take_examples(arguments, diagnostics);
  if (diagnostics.has_errors()) {
    print_messages(diagnostics, Verbosity::kNormal);
    return kExitBadInput;
  }
  auto solvers = choose_solvers(arguments.solvers, diagnostics);
  std::vector<std::string> settings = settings_of(arguments);
  for (std::string& setting : solve_settings(arguments.max_time, arguments.threads))
    settings.push_back(std::move(setting));
  std::optional<std::deque<BenchProblem>> problems =
      read_bench_problems(arguments.inputs, settings, arguments.drop, diagnostics);
  print_messages(diagnostics, Verbosity::kVerbose);
  if (!problems) return kExitBadInput;
  const InterruptGuard guard;
  if (!arguments.folder.empty()) create_folder(arguments.folder);
  Bench bench(arguments, std::move(solvers), *problems);
  bench.run();
  const bool kept_word = bench.finish();
  if (InterruptGuard::signal() != 0) return kExitSignalBase + InterruptGuard::signal();
  return kept_word ? kExitConverged : kExitNotConverged;
}

}  // namespace

Command bench_command() {
  const auto a = std::make_shared<BenchArguments>();
  return {
      .name = "conddp bench",
      .description = "Compare solvers on problems: time, iterations, answers",
      .details =
          "Every solver gets the same problem, guess and options, and its answer is measured by "
          "the same check. One solve at a time unless --jobs says otherwise; times are medians "
          "after a warm-up. Without a file: the problems in the folder 'problems', else those "
          "installed with conddp, each solve within 10 s. Solves that fail and unsupported "
          "problems "
          "stay in the table; the exit status is 1 where the check does not confirm an answer that "
          "a solver called converged.",
      .arguments =
          {{.names = {"FILE"},
            .value = "FILE.yaml",
            .description = "Problem files, folders of them, or names of example problems",
            .target = &a->inputs},
           {.names = {"--solvers"},
            .value = "NAMES",
            .description =
                "Solvers: comma-separated names, which may include auto, or all (without auto)",
            .fallback = a->solvers,
            .target = &a->solvers},
           drop_argument(a->drop,
                         "Drop this constraint for solvers that do not support it; 'all' for every "
                         "constraint; the table marks such solves"),
           {.names = {"--repeat"},
            .value = "N",
            .description = "Timed solves after a warm-up solve; 0: time only the first solve. By "
                           "default, a first solve longer than a second is also the only one",
            .numbers = WholeNumbers{0, 1000000},
            .fallback = std::to_string(kRepeat),
            .target = &a->repeat},
           threads_argument(a->threads, "Threads of each solve instead of the file's"),
           {.names = {"-j", "--jobs"},
            .value = "N",
            .description = "Number of parallel solves, for many instances. The answers do not "
                           "change, but the times include the load of the other solves",
            .numbers = WholeNumbers{1, 1024},
            .fallback = std::to_string(a->jobs),
            .target = &a->jobs},
           {.names = {"--tolerance"},
            .value = "NAME=NUMBER",
            .description = "Tolerance instead of the files': stationarity, gap or constraint",
            .check = named_number({"stationarity", "gap", "constraint"}, 1e-300, 1e300,
                                  "a number above 0"),
            .target = &a->tolerances},
           max_time_argument(a->max_time, "Stop each solve after this many seconds"),
           perturbation_argument(a->perturbations,
                                 "Solve random instances: initial_state=S moves the initial state "
                                 "by a tangent vector with entries within S, guess=S adds normal "
                                 "numbers of standard deviation S to the guess; repeatable"),
           {.names = {"--instances"},
            .value = "N",
            .description = "Random instances of each problem",
            .numbers = WholeNumbers{1, 1000000},
            .fallback = std::to_string(a->instances),
            .needs = "--perturb",
            .target = &a->instances},
           seed_argument(a->seed,
                         "Seed of the first instance; each further one has the next number"),
           setting_argument(a->settings,
                            "Replace a value in every problem, as in --set "
                            "solver.max_iterations=50"),
           {.names = {"-o", "--output"},
            .value = "FOLDER",
            .description =
                "Folder for the tables (bench.json, bench.csv, bench.md) and performance "
                "profiles (profiles.svg, if gnuplot is installed)",
            .target = &a->folder},
           flag({"--json"}, a->json, "Print JSON (conddp schema bench) instead of tables")},
      .run = [a] { return bench(*a); }};
}

}  // namespace conddp
