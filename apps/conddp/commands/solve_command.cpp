#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "analysis/certificate/certificate_doubt.hpp"
#include "analysis/contact/simulated_contacts.hpp"
#include "analysis/findings/findings.hpp"
#include "arguments/problem_arguments.hpp"
#include "arguments/shared_arguments.hpp"
#include "base/files/atomic_file.hpp"
#include "commands/commands.hpp"
#include "ocp/knot/knot_model.hpp"
#include "output/report/certificate_report.hpp"
#include "output/report/solution_certificate.hpp"
#include "output/solution/solution_json.hpp"
#include "problem_file/assemble/homotopy.hpp"
#include "problem_file/assemble/problem_names.hpp"
#include "problem_file/mesh/mesh.hpp"
#include "solvers/strategies/registry.hpp"
#include "solvers/strategies/strategies.hpp"
#include "summary/summary.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/messages.hpp"
#include "terminal/status_line.hpp"
#include "terminal/streams.hpp"
#include "terminal/terminal.hpp"

namespace conddp {
namespace {

struct SolveArguments : ProblemArguments {
  std::vector<std::string> others;  ///< further files
  std::string warm_start;
  bool report = false;
  bool no_verify = false;
};

/// Command-line settings for the solution. They include a warm start, whose path is relative to the
/// current folder, not to that of the problem file.
std::vector<std::string> overrides(const SolveArguments& arguments) {
  std::vector<std::string> list = settings_of(arguments);
  if (!arguments.warm_start.empty())
    list.push_back("initial_guess={file: " + arguments.warm_start + "}");
  return list;
}

int exit_code(SolveStatus status) {
  if (is_success(status)) return kExitConverged;
  if (status == SolveStatus::interrupted && InterruptGuard::signal() != 0)
    return kExitSignalBase + InterruptGuard::signal();
  return kExitNotConverged;
}

/// Measured time of the derivatives of all knots, s: the time of a full batch of the first knot of
/// each phase, times the number of batches.
double differentiation_time(const ShootingProblem& problem, const Trajectory& guess) {
  double seconds = 0;
  int k = 0;
  for (const Phase& phase : problem.phases()) {
    KnotBatch<Lane> batch(*phase.model);
    std::copy_n(guess.x(k).data(), phase.model->nx(), batch.x.begin());
    std::copy_n(guess.u(k).data(), phase.model->nu(), batch.u.begin());
    std::copy_n(phase.parameters.data(), phase.model->parameter_count(), batch.parameters.begin());
    batch.dt = phase.dt.front();
    batch.cost_scale = phase.cost_scale.front();
    const auto began = std::chrono::steady_clock::now();
    phase.model->differentiate(batch.input(), batch.work, true);
    const std::chrono::duration<double> gone = std::chrono::steady_clock::now() - began;
    seconds += gone.count() * ((phase.knots() + kLaneWidth - 1) / kLaneWidth);
    k += phase.knots();
  }
  return seconds;
}

/// Estimated time for the files of an answer, and for its certificate if requested, s; 0 without a
/// time limit. Both grow with the number of written values. The certificate also grows with the
/// time of derivatives, and counts as four times those of all knots.
double finishing_time(const BuiltProblem& built, bool certified) {
  if (!std::isfinite(built.facts().solver.options.max_time_s)) return 0;
  const ShootingProblem& problem = *built.problem;
  constexpr double kWrittenNumber = 4e-7, kComparedNumber = 5e-7, kEvaluatedKnot = 5e-6;
  constexpr double kDifferentiations = 4;
  double numbers = 0;
  for (int k = 0; k < problem.knots(); ++k)
    numbers += problem.nx() + 2 * problem.ndx() + problem.nu(k) * (problem.ndx() + 2.0);
  const double written = kWrittenNumber * numbers;
  if (!certified) return written;
  return written + kComparedNumber * numbers + kEvaluatedKnot * problem.knots() +
         kDifferentiations * differentiation_time(problem, built.guess);
}

/// Reports an error at the number of knots if finishing alone would far exceed the time limit.
bool leaves_time(const BuiltProblem& built, double finishing, Diagnostics& out) {
  constexpr double kByFar = 1;  // s
  const double limit = built.facts().solver.options.max_time_s;
  if (finishing <= limit + kByFar) return true;
  out.error(place_of_most_knots(built),
            fmt::format("after a solve of {} knots, the certificate and the files take about "
                        "{:.2g} s, and the time limit is {:g} s",
                        built.problem->knots(), finishing, limit),
            "take fewer knots, a longer limit (--max-time, solver.max_time_s) or --no-verify");
  return false;
}

/// Prints one line per iteration to stderr, with an occasional heading.
class ProgressTable {
 public:
  void print(const IterationRecord& row) {
    constexpr int kRepeatHeading = 20;
    if (row.homotopy != share_)
      print_message(fmt::format("homotopy at s = {:.4g}\n", row.homotopy));
    share_ = row.homotopy;
    if (row.restoration > restoration_) print_message("restoration of feasibility\n");
    restoration_ = row.restoration;
    if (lines_++ % kRepeatHeading == 0)
      print_message(fmt::format("{:>5} {:>14} {:>12} {:>10} {:>10} {:>8} {:>6} {:>9} {:>8}\n",
                                "iter", "cost", "stationarity", "gap", "constraint", "step",
                                "sweeps", "regular.", "time [s]"));
    print_message(fmt::format(
        "{:>5} {:>14.7g} {:>12.3e} {:>10.2e} {:>10.2e} {:>8.3g} {:>6} {:>9.1e} {:>8.3f}\n",
        row.iteration, row.cost, row.stationarity, row.gap, row.constraint, row.step, row.sweeps,
        row.regularization, row.time_s));
  }

 private:
  int lines_ = 0;
  double share_ = 1;     ///< of the homotopy
  int restoration_ = 0;  ///< restoration of the current rows, 0: none
};

/// Progress is a redrawn terminal line, or a table if notes are requested. Machine-readable
/// messages exclude both.
SolveResult solve_showing_progress(const BuiltProblem& built, bool first_grid, const Doubt& doubt,
                                   const std::vector<const SolverInfo*>& candidates,
                                   SolverOptions options, Verbosity verbosity,
                                   const SolverInfo*& solver) {
  // Signals have their usual effect before the first iterate, when there is nothing to save, and
  // after the last one, when the answer is either complete or not written.
  std::optional<InterruptGuard> guard;
  const bool text = message_format() == MessageFormat::kText;
  StatusLine status(text && verbosity == Verbosity::kNormal && terminal_of(2).redraws);
  ProgressTable table;
  options.interrupted = [&] {
    status.refresh();
    return InterruptGuard::signal() != 0;
  };
  options.on_iteration = [&](const IterationRecord& row) {
    if (!guard) guard.emplace();
    status.show(row);
    if (text && verbosity == Verbosity::kVerbose) table.print(row);
  };
  if (first_grid) {
    options.multipliers = built.multipliers;
    options.homotopy = homotopy_path(built);
  } else {
    options.restarts.count = 0;
  }
  const bool looks_further = first_grid && built.facts().solver.name.value == kAutoSolver;
  return looks_further ? solve_best(*built.problem, candidates, options, built.guess, solver, doubt)
                       : solve(*built.problem, candidates, options, built.guess, solver, doubt);
}

/// Number of notes that only --verbose shows.
int count_hidden_notes(const Diagnostics& diagnostics, bool verbose) {
  const auto is_note = [](const Diagnostic& d) { return d.severity == Severity::kNote; };
  const auto& list = diagnostics.list();
  return verbose ? 0 : static_cast<int>(std::count_if(list.begin(), list.end(), is_note));
}

/// A problem with its supporting solvers.
struct Task {
  BuiltProblem built;
  std::vector<const SolverInfo*> candidates;
  double finishing = 0;  ///< estimated time for files and certificate, s
  std::string grid;      ///< setting of a grid that differs from the file's
  /// Certificate of the solve, for its answer.
  std::shared_ptr<LastJudged> judged = std::make_shared<LastJudged>();

  const SolverSpec& asked() const { return built.facts().solver; }
};

/// The task of the command line; empty with errors if there is nothing to solve.
std::optional<Task> prepare(const SolveArguments& arguments, Diagnostics& out) {
  BuildOptions options = build_options_of(arguments);
  if (const std::string& file = arguments.warm_start; !file.empty())
    options.start = {file, {{out.add_source("--warm-start", file), 1, 1}, "initial_guess"}};
  auto built = build_problem_of(arguments, options, out);
  if (!built) return std::nullopt;
  Task task{.built = *std::move(built)};
  task.candidates = usable_solvers(task.built, out);
  task.finishing = finishing_time(task.built, !arguments.no_verify);
  if (task.candidates.empty() || !leaves_time(task.built, task.finishing, out)) return std::nullopt;
  return task;
}

/// Notes the first solver, if the file selects `auto`.
void note_auto(const Task& task, Diagnostics& out) {
  const Name& name = task.asked().name;
  if (name.value == kAutoSolver)
    out.note(name.place, "auto: " + describe_auto(*task.built.problem, task.candidates));
}

/// Writes the files of an answer; returns their paths.
std::vector<std::string> write_files(const SolveArguments& arguments, const Solution& solution,
                                     const OrderedJson& document) {
  std::string page;
  if (arguments.report)
    page = report_text(report_data({{.label = std::string(solution.solver.name),
                                     .document = document,
                                     .built = &solution.built}}));
  const auto folder = output_folder(arguments, solution.built);
  std::vector<std::string> written;
  for (const auto& path : write_solution(solution, document, folder, page))
    written.push_back(path.string());
  return written;
}

void print_answer(const SolveArguments& arguments, const Solution& solution,
                  const SolutionCertificate* certificate, const std::vector<std::string>& written,
                  int hidden_notes) {
  if (arguments.json) {
    OrderedJson head = solution_head(solution);
    if (certificate != nullptr) add_certificate(certificate_json(*certificate), head);
    print_result(json_text(head));
  } else if (!arguments.quiet) {
    print_as_it_is(
        summary_text(solution, certificate, written, terminal_of(1).colour, hidden_notes));
  }
}

/// The exit status of an answer with its certificate; prints a failed certificate.
int checked_exit_code(const SolutionCertificate& certificate, const BuiltProblem& built,
                      SolveStatus status) {
  if (!certificate.checks.computable() && !runs_code(built)) {
    print_error("the answer cannot be checked: " + certificate_line(certificate),
                "its numbers are so large that rounding or overflow makes them meaningless");
    return std::max<int>(kExitNotConverged, exit_code(status));
  }
  if (certificate.checks.holds())
    return is_denied(certificate.checks.verdict()) ? kExitNotConverged : exit_code(status);
  if (runs_code(built)) {
    print_error("the certificate of the answer " + certificate_line(certificate),
                "compiled code must give finite values and their derivatives: 'conddp check "
                "--derivatives' compares them");
    return std::max<int>(kExitNotConverged, exit_code(status));
  }
  const auto stiff =
      std::ranges::find(certificate.findings, FindingKind::unstable_steps, &Finding::kind);
  if (certificate.checks.doubts_optimality_alone() && stiff != certificate.findings.end()) {
    print_error("the certificate of the answer " + certificate_line(certificate),
                stiff->message + "; try " + stiff->remedy);
    return std::max<int>(kExitNotConverged, exit_code(status));
  }
  if (certificate.checks.doubts_optimality_alone()) {
    print_error("the certificate of the answer " + certificate_line(certificate),
                "the motion is correct, but its optimality cannot be decided: a problem is "
                "ill-conditioned if controls or states cost next to nothing; give them a cost, "
                "larger weights to all costs, or a smaller solver.tolerances.stationarity");
    return std::max<int>(kExitNotConverged, exit_code(status));
  }
  print_error("the certificate of the answer " + certificate_line(certificate),
              "this is a defect of conddp; please report it with the command and its files");
  return kExitDefect;
}

/// The task on another grid; empty with errors if that grid cannot be built.
std::optional<Task> on_other_grid(const SolveArguments& arguments, const Task& task,
                                  const OtherGrid& grid, Diagnostics& out) {
  auto built = build_on_grid(task.built, grid, out);
  if (!built) return std::nullopt;
  Task other{.built = *std::move(built), .candidates = task.candidates};
  other.finishing = finishing_time(other.built, !arguments.no_verify);
  other.grid = grid_setting(task.built, grid.factor);
  return other;
}

/// Uses the answer on another grid as the guess.
void start_from(const Task& former, const SolveResult& answer, Task& task) {
  task.built.guess = on_grid(*former.built.problem, answer.trajectory, *task.built.problem);
  task.built.guess_used = former.built.guess_used;
}

/// Objections of the certificate; `auto` also objects to motions that jump through what they should
/// go around.
Doubt doubt_of(const SolveArguments& arguments, const Task& task, const SolverOptions& options) {
  if (arguments.no_verify) return nullptr;
  Doubt doubt = certificate_doubt(options, task.judged, tangent_columns(task.built));
  if (task.asked().name.value != kAutoSolver) return doubt;
  return [doubt](const ShootingProblem& problem, const SolveResult& result) {
    Objection objection = doubt(problem, result);
    const auto jumps = find_jumps(problem, result.trajectory);
    objection.jumps = !jumps.empty();
    if (objection.text.empty() && objection.jumps) objection.text = jumps.front().message;
    return objection;
  };
}

using TimePoint = std::chrono::steady_clock::time_point;

/// Solves on successive grids, within the time limit of the command.
class GridSolve {
 public:
  GridSolve(const SolveArguments& arguments, TimePoint began, Task& task)
      : arguments_(arguments), began_(began), task_(task) {}

  /// The answer on the last grid, whose task replaces the member. Without `mesh`, and unless `auto`
  /// searches further, that is the file's own grid. Empty with errors if a finer grid cannot be
  /// built.
  std::optional<SolveResult> run(Diagnostics& out) {
    SolveResult result = solve(task_, true);
    if (task_.built.facts().mesh) return refine(std::move(result), out);
    if (task_.asked().name.value != kAutoSolver || arguments_.no_verify ||
        task_.asked().options.look_further == 0)
      return result;
    if (!jumps_of(task_, result).empty()) return solve_around(std::move(result));
    if (!is_given_up(result.status)) return result;
    if (auto other = solve_from_simulation(result)) return other;
    return climb(task_, std::move(result), 1);
  }

  const SolverInfo* solver() const { return solver_; }
  const std::vector<MeshRound>& rounds() const { return rounds_; }

 private:
  /// Limits of `auto`: the knots of a detour, relative to the file's, and the number of times that
  /// the knots are halved for a guess.
  static constexpr int kMostKnots = 4, kMostHalvings = 2;
  /// The maximum value of the option: the first detour is rarely good.
  static constexpr int kLargestWork = 1'000'000'000;

  /// The time limit may only leave time to evaluate the guess.
  SolveResult solve(const Task& task, bool first_grid) {
    return solve(task, first_grid, task.asked().options);
  }
  SolveResult solve(const Task& task, bool first_grid, SolverOptions options) {
    const std::chrono::duration<double> gone = std::chrono::steady_clock::now() - began_;
    options.max_time_s = std::max(1e-3, options.max_time_s - gone.count() - task.finishing);
    SolveResult result =
        solve_showing_progress(task.built, first_grid, doubt_of(arguments_, task, options),
                               task.candidates, options, verbosity_of(arguments_), solver_);
    seconds_ += result.times.total;
    return result;
  }

  std::optional<SolveResult> refine(SolveResult result, Diagnostics& out) {
    MeshRefinement mesh(*task_.built.facts().mesh);
    while (const auto factor = mesh.next(*task_.built.problem, result)) {
      auto finer = on_other_grid(arguments_, task_, {.factor = *factor}, out);
      if (!finer) return std::nullopt;
      start_from(task_, result, *finer);
      task_ = *std::move(finer);
      result = solve(task_, false, options_near(task_.asked().options));
    }
    rounds_ = mesh.rounds();
    return result;
  }

  static std::vector<Finding> jumps_of(const Task& task, const SolveResult& result) {
    if (!is_success(result.status)) return {};
    return find_jumps(*task.built.problem, result.trajectory);
  }

  /// The first answer on a finer grid without jumps, else the former answer.
  SolveResult solve_around(SolveResult former) {
    const SolverInfo* const solver = solver_;
    for (int factor = 2; factor <= kMostKnots; factor *= 2) {
      Diagnostics ignored;
      auto finer = on_other_grid(arguments_, task_, {.factor = factor}, ignored);
      if (!finer) break;
      SolverOptions options = finer->asked().options;
      options.look_further = kLargestWork;
      SolveResult result = solve(*finer, true, options);
      if (is_stopped(result.status)) break;
      if (!is_success(result.status) || !jumps_of(*finer, result).empty()) continue;
      result.message += fmt::format(
          "; on a grid {} times as fine as the file's, on which all answers jump through '{}'",
          factor, jumps_of(task_, former).front().subject);
      result.times.total = seconds_;
      task_ = *std::move(finer);
      return result;
    }
    solver_ = solver;
    return former;
  }

  static bool is_stopped(SolveStatus status) {
    return status == SolveStatus::time_limit || status == SolveStatus::interrupted;
  }
  /// True if all solvers ended without a statement about the problem.
  bool is_given_up(SolveStatus status) const {
    return !is_success(status) && !is_stopped(status) && status != SolveStatus::infeasible &&
           task_.asked().options.max_iterations >= SolverOptions().max_iterations;
  }

  /// The answer started from a simulation of the guess's controls, with its contacts; empty if the
  /// simulation or the solve fails.
  std::optional<SolveResult> solve_from_simulation(const SolveResult& failed) {
    auto simulated = simulated_guess(*task_.built.problem, task_.built.guess);
    if (!simulated) return std::nullopt;
    const SolverInfo* const solver = solver_;
    std::swap(task_.built.guess, *simulated);
    SolveResult result = solve(task_, false, options_near(task_.asked().options));
    result.times.total = seconds_;
    if (is_success(result.status)) {
      result.message += fmt::format("; from a simulation of the guess's controls, after {}",
                                    to_string(failed.status));
      return result;
    }
    std::swap(task_.built.guess, *simulated);
    solver_ = solver;
    return std::nullopt;
  }

  /// The answer started from the answer with the knots of the file halved this often, which may
  /// itself start from half of those; `failed` without such an answer.
  SolveResult climb(Task& task, SolveResult failed, int halvings) {
    const SolverInfo* const solver = solver_;
    Diagnostics ignored;
    auto coarse = on_other_grid(arguments_, task, {.halvings = halvings}, ignored);
    if (!coarse) return failed;
    SolveResult below = solve(*coarse, false);
    if (is_given_up(below.status) && halvings < kMostHalvings)
      below = climb(*coarse, std::move(below), halvings + 1);
    solver_ = solver;
    if (!is_success(below.status)) return failed;
    const Trajectory guess = task.built.guess;
    start_from(*coarse, below, task);
    SolveResult result = solve(task, false, options_near(task.asked().options));
    result.times.total = seconds_;
    if (is_success(result.status)) {
      result.message += fmt::format("; from the answer with {} knots, where all solvers failed",
                                    coarse->built.problem->knots());
      return result;
    }
    task.built.guess = guess;
    solver_ = solver;
    failed.times.total = seconds_;
    return failed;
  }

  const SolveArguments& arguments_;
  const TimePoint began_;
  Task& task_;
  const SolverInfo* solver_ = nullptr;
  double seconds_ = 0;  ///< total of all solves
  std::vector<MeshRound> rounds_;
};

int solve_file(const SolveArguments& arguments) {
  const auto began = std::chrono::steady_clock::now();
  const Verbosity verbosity = verbosity_of(arguments);
  Diagnostics diagnostics;
  std::optional<Task> task = prepare(arguments, diagnostics);
  if (task && arguments.verbose) note_auto(*task, diagnostics);
  print_messages(diagnostics, verbosity);
  if (!task || (arguments.report && !reports_can_be_made())) return kExitBadInput;
  create_folder(output_folder(arguments, task->built));  // so that a failure wastes no work
  GridSolve solve(arguments, began, *task);
  Diagnostics of_grids;  // repeats messages of the first grid
  const auto result = solve.run(of_grids);
  if (!result) {
    print_messages(of_grids, Verbosity::kQuiet);
    return kExitBadInput;
  }
  Solution solution{task->built, *solve.solver(), *result, overrides(arguments), solve.rounds()};
  solution.answer.judged = task->judged;
  if (!solution.mesh.empty())
    solution.overrides.push_back(grid_setting(task->built, solution.mesh.back().factor));
  else if (!task->grid.empty())
    solution.overrides.push_back(task->grid);
  OrderedJson document = solution_json(solution);
  std::optional<SolutionCertificate> certificate;
  if (!arguments.no_verify) {
    certificate = certify_answer(solution);
    note_nulls(document, certificate->checks);
    add_certificate(certificate_json(*certificate), document);
  }
  print_answer(arguments, solution, certificate ? &*certificate : nullptr,
               write_files(arguments, solution, document),
               count_hidden_notes(diagnostics, arguments.verbose));
  const int code = certificate ? checked_exit_code(*certificate, task->built, result->status)
                               : exit_code(result->status);
  const bool fine_enough =
      solution.mesh.empty() || solution.mesh.back().error <= task->built.facts().mesh->error;
  return fine_enough ? code : std::max<int>(kExitNotConverged, code);
}

/// Separate arguments for each of several files.
std::vector<SolveArguments> one_by_one(const SolveArguments& arguments) {
  std::vector<std::string> files = arguments.others;
  files.insert(files.begin(), arguments.file);
  const std::filesystem::path folder = arguments.folder.empty() ? "out" : arguments.folder;
  std::vector<SolveArguments> list;
  for (const std::string& file : files) {
    SolveArguments& one = list.emplace_back(arguments);
    one.file = file;
    one.folder =
        folder / (file == kStandardInput ? "stdin" : std::filesystem::path(file).stem().string());
  }
  return list;
}

/// True if all files can be read and have distinct folders; otherwise reports the reason.
bool can_be_solved(const std::vector<SolveArguments>& list) {
  bool possible = true;
  std::set<std::string> folders;
  for (const SolveArguments& one : list) {
    Diagnostics diagnostics;
    if (!names_folder(std::filesystem::path(one.folder).filename().string()))
      diagnostics.error({}, fmt::format("the answer of '{}' has no folder", one.file),
                        "the file's name cannot name a folder; solve it alone, with --output");
    if (!folders.insert(one.folder).second)
      diagnostics.error({}, fmt::format("two problems would be written to '{}'", one.folder),
                        "solve them one by one, with --output");
    if (one.file != kStandardInput)
      read_problem(load_problem_of(one, diagnostics), settings_of(one), diagnostics);
    print_messages(diagnostics, Verbosity::kQuiet);
    possible = possible && !diagnostics.has_errors();
  }
  return possible;
}

/// Solves all files in sequence, each into a folder named after its file. All files are read before
/// the first solve. Returns the worst exit status.
int solve_files(const SolveArguments& arguments) {
  if (arguments.others.empty()) return solve_file(arguments);
  const std::vector<SolveArguments> list = one_by_one(arguments);
  if (!can_be_solved(list)) return kExitBadInput;
  int worst = kExitConverged;
  for (const SolveArguments& one : list) {
    const int code = solve_file(one);
    if (code > kExitSignalBase) return code;
    worst = std::max(worst, code);
  }
  return worst;
}

}  // namespace

Command solve_command() {
  const auto a = std::make_shared<SolveArguments>();
  return {
      .name = "conddp solve",
      .description = "Solve a problem file",
      .details =
          "Writes solution.json, trajectory.csv and iterations.csv, all of them or none. "
          "Ctrl-C ends the solve and writes the best iterate.",
      .arguments = joined(
          problem_arguments(*a),
          {{.names = {"MORE"},
            .value = "FILE.yaml",
            .description = "Further problem files, each solved into FOLDER/<its name>",
            .target = &a->others},
           {.names = {"-o", "--output"},
            .value = "FOLDER",
            .description = "Folder for the outputs (default: out/<problem name>)",
            .target = &a->folder},
           {.names = {"--warm-start"},
            .value = "FILE.json",
            .description = "Start from the states and controls of a former solution.json, "
                           "interpolated to this problem's knots, instead of the file's initial "
                           "guess",
            .target = &a->warm_start},
           max_time_argument(a->max_time, "Stop after this many seconds"),
           threads_argument(a->threads, "Threads; results do not depend on it"),
           flag({"--quiet"}, a->quiet, "Print nothing but errors"),
           flag({"--report"}, a->report, "Write report.html too, to see the motion in a browser"),
           flag({"--json"}, a->json, "Print the head of the solution as JSON on stdout"),
           flag({"-v", "--verbose"}, a->verbose,
                "Print notes, and a line of figures each iteration", "--quiet"),
           flag({"--no-verify"}, a->no_verify,
                "Skip the certificate, which checks the answer with code independent of the "
                "solvers")}),
      .run = [a] { return solve_files(*a); }};
}

}  // namespace conddp
