#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "analysis/findings/findings.hpp"
#include "arguments/problem_arguments.hpp"
#include "arguments/shared_arguments.hpp"
#include "base/files/atomic_file.hpp"
#include "commands/commands.hpp"
#include "output/report/certificate_report.hpp"
#include "output/report/solution_certificate.hpp"
#include "output/solution/grid_solve.hpp"
#include "output/solution/solution_json.hpp"
#include "problem_file/assemble/problem_names.hpp"
#include "solvers/strategies/registry.hpp"
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
  std::string formats = "json,csv";
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

/// Progress of a solve, with the callbacks that show it and end the solve at a signal: a redrawn
/// terminal line, or a table if notes are requested. Machine-readable messages exclude both.
class Watch {
 public:
  Watch(Verbosity verbosity, SolverOptions& options)
      : shows_table_(is_text() && verbosity == Verbosity::kVerbose),
        status_(is_text() && verbosity == Verbosity::kNormal && terminal_of(2).redraws) {
    options.interrupted = [this] {
      status_.refresh();
      return InterruptGuard::signal() != 0;
    };
    options.on_iteration = [this](const IterationRecord& row) {
      if (!guard_) guard_.emplace();
      status_.show(row);
      if (shows_table_) table_.print(row);
    };
  }

 private:
  static bool is_text() { return message_format() == MessageFormat::kText; }

  const bool shows_table_;
  /// Signals have their usual effect before the first iterate, when there is nothing to save, and
  /// after the last one, when the answer is either complete or not written.
  std::optional<InterruptGuard> guard_;
  StatusLine status_;
  ProgressTable table_;
};

/// Number of notes that only --verbose shows.
int count_hidden_notes(const Diagnostics& diagnostics, bool verbose) {
  const auto is_note = [](const Diagnostic& d) { return d.severity == Severity::kNote; };
  const auto& list = diagnostics.list();
  return verbose ? 0 : static_cast<int>(std::count_if(list.begin(), list.end(), is_note));
}

/// The task of the command line; empty with errors if there is nothing to solve.
std::optional<SolveTask> prepare(const SolveArguments& arguments, Diagnostics& out) {
  BuildOptions options = build_options_of(arguments);
  if (const std::string& file = arguments.warm_start; !file.empty())
    options.start = {file, {{out.add_source("--warm-start", file), 1, 1}, "initial_guess"}};
  auto built = build_problem_of(arguments, options, out);
  if (!built) return std::nullopt;
  SolveTask task{.built = *std::move(built)};
  task.candidates = usable_solvers(task.built, out);
  task.finishing = finishing_time(task.built, !arguments.no_verify);
  if (task.candidates.empty() || !leaves_time(task.built, task.finishing, out)) return std::nullopt;
  return task;
}

/// Notes the first solver, if the file selects `auto`.
void note_auto(const SolveTask& task, Diagnostics& out) {
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
  for (const auto& path :
       write_solution(solution, document, folder, page, *parse_output_formats(arguments.formats)))
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
    const auto& model = certificate.checks.second_order;
    const std::string repeated = model ? model->doubtful : "";
    print_error("the certificate of the answer " + certificate_line(certificate),
                repeated.empty()
                    ? "the motion is correct, but its optimality cannot be decided: a problem is "
                      "ill-conditioned if controls or states cost next to nothing; give them a "
                      "cost, larger weights to all costs, or a smaller "
                      "solver.tolerances.stationarity"
                    : fmt::format("the motion is correct; leave '{0}' out (--drop {0}) if the rest "
                                  "implies it, or hold fewer of its rows",
                                  repeated));
    return std::max<int>(kExitNotConverged, exit_code(status));
  }
  print_error("the certificate of the answer " + certificate_line(certificate),
              "this is a defect of conddp; please report it with the command and its files");
  return kExitDefect;
}

int solve_file(const SolveArguments& arguments) {
  const auto began = std::chrono::steady_clock::now();
  const Verbosity verbosity = verbosity_of(arguments);
  Diagnostics diagnostics;
  std::optional<SolveTask> task = prepare(arguments, diagnostics);
  if (task && arguments.verbose) note_auto(*task, diagnostics);
  print_messages(diagnostics, verbosity);
  if (!task || (arguments.report && !reports_can_be_made())) return kExitBadInput;
  create_folder(output_folder(arguments, task->built));  // so that a failure wastes no work
  const auto watch = [verbosity](SolverOptions& options) {
    return std::make_shared<Watch>(verbosity, options);
  };
  GridSolve solve(*task, {.verify = !arguments.no_verify, .began = began, .watch = watch});
  Diagnostics of_grids;  // repeats messages of the first grid
  const auto result = solve.run(of_grids);
  if (!result) {
    print_messages(of_grids, Verbosity::kQuiet);
    return kExitBadInput;
  }
  Solution solution{task->built, *solve.solver(), *result, solve.with_grid(overrides(arguments)),
                    solve.rounds()};
  solution.answer.judged = task->judged;
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
           {.names = {"--output-format"},
            .value = "LIST",
            .description = "Forms of the answer, separated by commas: json (solution.json), csv "
                           "(trajectory.csv, iterations.csv), npz (trajectory.npz for NumPy)",
            .check =
                [](const std::string& list) {
                  return parse_output_formats(list)
                             ? std::string()
                             : fmt::format("'{}' is not a list of {}", list, kOutputFormats);
                },
            .fallback = a->formats,
            .target = &a->formats},
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
