#include <algorithm>
#include <cstdlib>
#include <memory>
#include <set>

#include <sys/wait.h>
#include <unistd.h>

#include <fmt/format.h>

#include "arguments/shared_arguments.hpp"
#include "base/files/atomic_file.hpp"
#include "base/json/json_document.hpp"
#include "commands/commands.hpp"
#include "output/bench/bench_runs.hpp"
#include "output/report/motion_video.hpp"
#include "output/solution/solved_problem.hpp"
#include "summary/summary.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/messages.hpp"
#include "terminal/status_line.hpp"
#include "terminal/streams.hpp"
#include "terminal/terminal.hpp"

namespace conddp {
namespace {

namespace fs = std::filesystem;

struct ReportArguments {
  std::vector<std::string> solutions;
  std::string problem;
  std::string bench;
  std::string file;
  std::string video;
  bool open = false;
};

constexpr std::string_view kKept[] = {"problem",
                                      "tool",
                                      "solver",
                                      "status",
                                      "message",
                                      "cost",
                                      "residuals",
                                      "iterations",
                                      "time_s",
                                      "cost_by_name",
                                      "free_numbers",
                                      "gains",
                                      "trajectory",
                                      "multipliers",
                                      "log",
                                      "findings",
                                      "soft_constraints",
                                      "dropped_constraints",
                                      "diagnosis",
                                      "certificate",
                                      "initial_guess_used"};

/// Labels of solutions: the solver if all solvers differ, else the folder.
std::vector<std::string> labels(const std::vector<std::string>& files,
                                const std::vector<OrderedJson>& documents) {
  std::vector<std::string> solvers, folders;
  for (std::size_t i = 0; i < files.size(); ++i) {
    solvers.push_back(solution_text(documents[i], "solver"));
    std::error_code error;
    folders.push_back(fs::absolute(files[i], error).parent_path().filename().string());
  }
  const auto differ = [](std::vector<std::string> names) {
    std::sort(names.begin(), names.end());
    return std::adjacent_find(names.begin(), names.end()) == names.end();
  };
  if (differ(solvers)) return solvers;
  return differ(folders) ? folders : files;
}

/// Opens a file with the desktop's program; its output is not ours.
void open_in_browser(const std::string& file) {
  const pid_t child = fork();
  if (child == 0) {
    execlp("xdg-open", "xdg-open", file.c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) < 0 || !WIFEXITED(status) || WEXITSTATUS(status) != 0)
    print_error("the report could not be opened", "open " + file + " in a browser");
}

/// The files of the command line; empty if one of them cannot be used.
struct Documents {
  std::vector<OrderedJson> solutions;
  std::optional<OrderedJson> bench;
};

std::optional<Documents> load_documents(const ReportArguments& arguments, Diagnostics& out) {
  Documents documents;
  for (const std::string& file : arguments.solutions)
    if (const auto document = load_document(file, kSolutionDocument, kKept, {}, out))
      documents.solutions.emplace_back(*document);
  if (!arguments.bench.empty())
    if (const auto document = load_document(arguments.bench, kBenchDocument, kBenchKeys, {}, out))
      documents.bench = *document;
  if (out.has_errors()) return std::nullopt;
  return documents;
}

/// Builds the problem of a solution for its entry. Missing files are not errors here: without its
/// problem, a solution still has curves.
std::unique_ptr<const BuiltProblem> problem_of(ReportEntry& entry, const std::string& file,
                                               const std::string& problem_file, Diagnostics& out) {
  Diagnostics about;
  std::unique_ptr<const BuiltProblem> problem;
  if (auto built = rebuild_problem(entry.document, file, problem_file, about)) {
    problem = std::make_unique<const BuiltProblem>(*std::move(built));
    entry.built = problem.get();
  } else {
    entry.remark = "drawn without its robot, limits and costs over time: " +
                   (about.list().empty() ? "" : about.list().front().message);
  }
  for (Diagnostic d : about.list()) {
    d.source = -1;  // `out` has different sources; the file is read again
    if (d.severity == Severity::kError) d.severity = Severity::kWarning;
    out.add(std::move(d));
  }
  return problem;
}

/// The page's data; `file` is set to the file being processed.
OrderedJson data_of(const Documents& documents, const ReportArguments& arguments, std::string& file,
                    Diagnostics& out) {
  const std::size_t count = documents.solutions.size();
  std::set<std::string> problem_names;
  for (std::size_t i = 0; i < count; ++i) {
    file = arguments.solutions[i];
    check_report_document(documents.solutions[i]);
    problem_names.insert(solution_text(documents.solutions[i]["problem"], "name"));
  }
  const std::vector<std::string> names = labels(arguments.solutions, documents.solutions);
  std::vector<std::unique_ptr<const BuiltProblem>> problems;  // entries refer to them
  std::vector<ReportEntry> entries;
  for (std::size_t i = 0; i < count; ++i) {
    file = arguments.solutions[i];
    entries.push_back({.label = names[i], .document = documents.solutions[i]});
    problems.push_back(problem_of(entries.back(), file, arguments.problem, out));
  }
  OrderedJson data = report_data(entries);
  if (documents.bench) {
    file = arguments.bench;
    data["bench"] = bench_runs(*documents.bench, problem_names);
  }
  return data;
}

/// The browser that records the video, if one is wanted; reports an error if it is missing.
std::optional<fs::path> recording_browser(const ReportArguments& arguments) {
  if (arguments.video.empty()) return fs::path();
  const auto browser = find_browser();
  if (!browser)
    print_error(fmt::format("a video needs a browser, and none of {} is on the search path",
                            fmt::join(kBrowsers, ", ")),
                "install the package chromium (Ubuntu: chromium-browser)");
  return browser;
}

/// The video of a page's motion.
std::string video_of(const std::string& page, const OrderedJson& data, const fs::path& browser) {
  const OrderedJson& solutions = data.at("solutions");
  const auto has_picture = [](const OrderedJson& solution) { return !solution["scene"].is_null(); };
  if (std::ranges::none_of(solutions, has_picture)) {
    const std::string remark = solution_text(solutions.front(), "remark");
    throw OutputError("there is no picture to record: " +
                      (remark.empty() ? "the problem file says nothing to draw" : remark));
  }
  const InterruptGuard guard;
  StatusLine status(message_format() == MessageFormat::kText && terminal_of(2).redraws);
  return record_motion(
      page, {.program = browser, .interrupted = [] { return InterruptGuard::signal() != 0; }},
      [&](double share) { status.show(fmt::format("video {:.0f} %", 100 * share)); });
}

int report(const ReportArguments& arguments) {
  if (!reports_can_be_made()) return kExitBadInput;
  const auto browser = recording_browser(arguments);
  if (!browser) return kExitBadInput;
  Diagnostics diagnostics;
  std::string file;
  try {
    if (const auto documents = load_documents(arguments, diagnostics)) {
      const OrderedJson data = data_of(*documents, arguments, file, diagnostics);
      const fs::path out =
          arguments.file.empty()
              ? fs::path(arguments.solutions.front()).replace_filename("report.html")
              : fs::path(arguments.file);
      const std::string page = report_text(data);
      const std::string video =
          arguments.video.empty() ? std::string() : video_of(page, data, *browser);
      AtomicFiles files;
      files.add(out, page);
      if (!arguments.video.empty()) files.add(arguments.video, video);
      files.commit();
      print_messages(diagnostics, Verbosity::kNormal);
      print_result(out.string() + "\n");
      if (!arguments.video.empty()) print_result(arguments.video + "\n");
      if (arguments.open) open_in_browser(out.string());
      return kExitConverged;
    }
  } catch (const MalformedSolution& malformed) {
    diagnostics.add({.file = file, .message = malformed.what()});
  } catch (const OrderedJson::exception& error) {
    diagnostics.add({.file = file, .message = error.what()});
  } catch (const OutputError&) {
    if (InterruptGuard::signal() == 0) throw;
    return kExitSignalBase + InterruptGuard::signal();
  }
  print_messages(diagnostics, Verbosity::kNormal);
  return kExitBadInput;
}

}  // namespace

Command report_command() {
  const auto a = std::make_shared<ReportArguments>();
  return {
      .name = "conddp report",
      .description = "Make a page for the browser that shows solutions",
      .details =
          "One file that needs no network: the robot in 3-D with contact forces, a time line, "
          "every curve with its limits, the convergence of the solver, and how to reproduce it. If "
          "the problem of a solution is missing, the page shows its curves only.",
      .arguments = {{.names = {"FILE"},
                     .value = "FILE.json",
                     .description = "Solutions; the first one's robot is solid, others are ghosts",
                     .required = true,
                     .target = &a->solutions},
                    {.names = {"-o", "--output"},
                     .value = "FILE.html",
                     .description = "The page (default: report.html beside the first solution)",
                     .target = &a->file},
                    problem_of_solution(a->problem,
                                        "Problem file (default: the one named in each solution)"),
                    {.names = {"--bench"},
                     .value = "bench.json",
                     .description =
                         "Add a table of what 'conddp bench' measured of the same problems",
                     .target = &a->bench},
                    {.names = {"--video"},
                     .value = "FILE.webm",
                     .description = "Record the motion with an installed Chromium as a WebM video",
                     .target = &a->video},
                    flag({"--open"}, a->open, "Open the page with xdg-open")},
      .run = [a] { return report(*a); }};
}

}  // namespace conddp
