#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "analysis/comparison/benchmark.hpp"
#include "base/text/text_layout.hpp"
#include "output/bench/benchmark_report.hpp"

namespace conddp {
namespace {

using Entries = std::vector<const BenchmarkEntry*>;

std::string number(double value, const char* format) {
  return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : "-";
}

std::string residual(double value) { return value == 0 ? "0" : number(value, "{:.1e}"); }

std::string left_out_text(const BenchmarkEntry& entry) {
  std::string text;
  for (const LeftOut& constraint : entry.left_out)
    text += fmt::format("{}{} (off by {:.2g})", text.empty() ? "" : ", ", constraint.name,
                        constraint.violation);
  return text;
}

/// The status, or "check failed" if the check contradicts it.
std::string status_text(const BenchmarkRun& run) {
  return run.kept_word() ? run.status : "check failed";
}

/// A share of the solve time, µs per iteration.
std::string per_iteration(double time_s, const BenchmarkRun& run) {
  return run.times.empty() ? "" : number(1e6 * time_s / std::max(run.iterations, 1), "{:.0f}");
}

/// Headers of the columns of within_cells, one per cost level.
std::vector<TextTable::Column> within_columns() {
  std::vector<TextTable::Column> columns;
  for (const CostLevel& level : kCostLevels)
    columns.push_back({fmt::format("within {}", level.name)});
  return columns;
}

/// Percentages of the runs within each cost level.
std::vector<std::string> within_cells(const SolverSummary& summary) {
  std::vector<std::string> cells;
  for (const int count : summary.within)
    cells.push_back(summary.runs > 0 ? fmt::format("{:.1f} %", 100.0 * count / summary.runs) : "");
  return cells;
}

TextTable solver_table(const Entries& entries) {
  TextTable table{.columns = {{"solver", false},
                              {"status", false},
                              {"without", false},
                              {"iterations"},
                              {"time [ms]"},
                              {"spread"},
                              {"us/iteration"},
                              {"evaluate"},
                              {"differentiate"},
                              {"sweep"},
                              {"rollout"},
                              {"cost"},
                              {"excess"},
                              {"stationarity"},
                              {"gap"},
                              {"constraint"},
                              {"complementarity"}},
                  .rows = {}};
  for (const BenchmarkEntry* entry : entries) {
    const BenchmarkRun& run = entry->run;
    std::vector<std::string> row = {run.solver, status_text(run), left_out_text(*entry)};
    if (run.status == "refused") {
      row.resize(table.columns.size());
    } else {
      const SolveTimes& t = run.median;
      row.insert(row.end(), {std::to_string(run.iterations), number(1e3 * t.total, "{:.4g}"),
                             run.times.size() > 1 ? number(100 * run.spread(), "{:.0f} %") : "",
                             per_iteration(t.total, run), per_iteration(t.evaluate, run),
                             per_iteration(t.differentiate, run), per_iteration(t.sweep, run),
                             per_iteration(t.rollout, run), number(run.check.cost, "{:.9g}"),
                             std::isfinite(entry->cost_excess) ? residual(entry->cost_excess) : "",
                             residual(run.check.stationarity), residual(run.check.gap),
                             residual(run.check.constraint), residual(run.check.complementarity)});
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

/// Example: "3 diverged, 1 time_limit".
std::string failures_text(const SolverSummary& summary) {
  std::string text;
  for (const auto& [status, count] : summary.failures)
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, status);
  return text;
}

/// Summary of one solver's runs on all instances of a problem.
struct Runs {
  int count = 0, solved = 0;
  std::vector<double> iterations, times, excess;  ///< of solved runs
  double stationarity = 0, gap = 0, constraint = 0, off = 0;
  std::string without;  ///< constraints that the last run omitted

  void add(const BenchmarkEntry& entry) {
    ++count;
    note_left_out(entry.left_out);
    if (!entry.run.solved) return;
    solved += entry.left_out.empty();
    iterations.push_back(entry.run.iterations);
    times.push_back(1e3 * entry.run.median.total);
    if (std::isfinite(entry.cost_excess)) excess.push_back(entry.cost_excess);
    stationarity = std::max(stationarity, entry.run.check.stationarity);
    gap = std::max(gap, entry.run.check.gap);
    constraint = std::max(constraint, entry.run.check.constraint);
  }
  void note_left_out(const std::vector<LeftOut>& constraints) {
    std::string names;
    for (const LeftOut& c : constraints) {
      names += (names.empty() ? "" : ", ") + c.name;
      off = std::max(off, c.violation);
    }
    if (!names.empty()) without = fmt::format("{} (off by {:.2g})", names, off);
  }
  std::vector<std::string> cells() const {
    if (iterations.empty()) return std::vector<std::string>(6);
    return {number(median(iterations), "{:.4g}"),
            number(median(times), "{:.4g}"),
            excess.empty() ? "" : residual(median(excess)),
            residual(stationarity),
            residual(gap),
            residual(constraint)};
  }
};

/// The row of one solver over all instances of a problem.
std::vector<std::string> robustness_row(const std::string& solver, const Entries& entries) {
  Runs runs;
  BenchmarkReport part{.request = {.solvers = {solver}}};
  for (const BenchmarkEntry* entry : entries) {
    if (entry->run.solver != solver) continue;
    part.entries.push_back(*entry);
    if (entry->run.status != "refused") runs.add(*entry);
  }
  const SolverSummary summary = summarize(part).front();
  std::vector<std::string> row = {solver, fmt::format("{}/{}", runs.solved, runs.count)};
  for (std::string& cell : within_cells(summary)) row.push_back(std::move(cell));
  row.push_back(runs.without);
  for (std::string& cell : runs.cells()) row.push_back(std::move(cell));
  row.push_back(summary.refused > 0 ? fmt::format("{} unsupported", summary.refused)
                                    : failures_text(summary));
  return row;
}

TextTable robustness_table(const std::vector<std::string>& solvers, const Entries& entries) {
  TextTable table{.columns = {{"solver", false},
                              {"solved"},
                              {"without", false},
                              {"iterations"},
                              {"time [ms]"},
                              {"excess"},
                              {"stationarity"},
                              {"gap"},
                              {"constraint"},
                              {"otherwise", false}},
                  .rows = {}};
  const auto levels = within_columns();
  table.columns.insert(table.columns.begin() + 2, levels.begin(), levels.end());
  for (const std::string& solver : solvers) table.rows.push_back(robustness_row(solver, entries));
  return table;
}

TextTable summary_table(const BenchmarkReport& report) {
  TextTable table{.columns = {{"solver", false},
                              {"solved"},
                              {"of"},
                              {"share"},
                              {"solved without a constraint"},
                              {"unsupported"},
                              {"otherwise", false}},
                  .rows = {}};
  const auto levels = within_columns();
  table.columns.insert(table.columns.begin() + 4, levels.begin(), levels.end());
  for (const SolverSummary& s : summarize(report)) {
    std::vector<std::string> row = {
        s.solver, std::to_string(s.solved), std::to_string(s.runs),
        s.runs > 0 ? fmt::format("{:.1f} %", 100.0 * s.solved / s.runs) : ""};
    for (std::string& cell : within_cells(s)) row.push_back(std::move(cell));
    row.insert(row.end(), {s.left_out > 0 ? fmt::format("{}/{}", s.solved_without, s.left_out) : "",
                           s.refused > 0 ? std::to_string(s.refused) : "", failures_text(s)});
    table.rows.push_back(std::move(row));
  }
  return table;
}

/// Example: "; 20 instances, initial states within 0.1, seeds 1 to 20"; empty without instances.
std::string instances_text(const BenchmarkRequest& request) {
  if (request.instances == 0) return {};
  std::string text = fmt::format("; {} instances", request.instances);
  if (request.initial_state_size)
    text += fmt::format(", initial states within {:g}", *request.initial_state_size);
  if (request.guess_spread)
    text += fmt::format(", guesses with deviation {:g}", *request.guess_spread);
  return text + fmt::format(", seeds {} to {}", request.seed, request.seed + request.instances - 1);
}

/// Example: "max_iterations=50, hessian=exact".
std::string options_text(const OrderedJson& options) {
  std::string text;
  for (const auto& [name, value] : options.items())
    text += fmt::format("{}{}={}", text.empty() ? "" : ", ", name,
                        value.is_string() ? value.get<std::string>() : value.dump());
  return text;
}

std::string heading(const BenchmarkEntry& entry, const BenchmarkRequest& request, bool markdown) {
  std::string text = fmt::format("{}{} ({} knots, {} states, {} controls", markdown ? "### " : "",
                                 entry.problem, entry.knots, entry.states, entry.controls);
  text += instances_text(request) + ")\n";
  if (markdown) text += '\n';
  if (entry.options.empty()) return text;
  return text + (markdown ? "Options: " : "  options: ") + options_text(entry.options) +
         (markdown ? "\n\n" : "\n");
}

/// A separate line with the command that solves an entry again.
std::string command_line(const BenchmarkEntry& entry, bool markdown) {
  return markdown ? fmt::format("  `{}`\n", entry.command) : fmt::format("    {}\n", entry.command);
}

/// Lines with the reason of unsupported problems and failures, and the command that reproduces it.
/// For several instances, only the first failure of each solver that supports them.
std::string failure_lines(const Entries& entries, bool markdown) {
  std::string text;
  std::set<std::string> told;
  for (const BenchmarkEntry* entry : entries) {
    const BenchmarkRun& run = entry->run;
    const bool refused = run.status == "refused";
    if (run.solved || (entry->seed && (refused || !told.insert(run.solver).second))) continue;
    text += fmt::format("{}{}{}: {}\n", markdown ? "- " : "  ", run.solver,
                        entry->seed ? fmt::format(", seed {}", *entry->seed) : "", run.message);
    if (!refused) text += command_line(*entry, markdown);
  }
  return text;
}

/// Answers that improve on the best known cost.
std::string discovery_lines(const Entries& entries, bool markdown) {
  std::string text;
  for (const BenchmarkEntry* entry : entries)
    if (beats_best_known(*entry))
      text += fmt::format("{}{}{}: {:.9g} is less than the best known cost, {:.9g}\n",
                          markdown ? "- " : "  ", entry->run.solver,
                          entry->seed ? fmt::format(", seed {}", *entry->seed) : "",
                          entry->run.check.cost, *entry->best_known) +
              command_line(*entry, markdown);
  return text;
}

std::string messages(const Entries& entries, bool markdown) {
  const std::string text = failure_lines(entries, markdown) + discovery_lines(entries, markdown);
  return markdown && !text.empty() ? '\n' + text : text;
}

std::string cell(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }

/// Entries of the same problem file, starting at index `first`.
Entries entries_from(const BenchmarkReport& report, std::size_t first) {
  Entries entries;
  for (std::size_t i = first;
       i < report.entries.size() && report.entries[i].file == report.entries[first].file; ++i)
    entries.push_back(&report.entries[i]);
  return entries;
}

}  // namespace

std::string benchmark_text(const BenchmarkReport& report, bool markdown) {
  const auto print = [&](const TextTable& table) {
    return markdown ? table.markdown() : table.text(2);
  };
  std::string text;
  int problems = 0;
  for (std::size_t i = 0; i < report.entries.size(); ++problems) {
    const Entries entries = entries_from(report, i);
    i += entries.size();
    if (problems > 0) text += '\n';
    text += heading(*entries.front(), report.request, markdown);
    text += print(report.request.instances > 0 ? robustness_table(report.request.solvers, entries)
                                               : solver_table(entries)) +
            messages(entries, markdown);
  }
  if (problems > 1)
    text +=
        (markdown ? "\n### All problems\n\n" : "\nall problems\n") + print(summary_table(report));
  return text;
}

std::string benchmark_csv(const BenchmarkReport& report) {
  std::string text =
      "problem,seed,solver,status,solved,without,iterations,sweeps,time [s],time smallest [s],"
      "time largest [s],evaluate [s],differentiate [s],sweep [s],rollout [s],cost,cost excess,"
      "stationarity,gap,constraint,complementarity\n";
  for (const BenchmarkEntry& entry : report.entries) {
    const BenchmarkRun& run = entry.run;
    std::vector<std::string> names;
    for (const LeftOut& constraint : entry.left_out) names.push_back(constraint.name);
    text += fmt::format("{},{},{},{},{},{},", entry.problem,
                        entry.seed ? std::to_string(*entry.seed) : "", run.solver, run.status,
                        run.solved ? 1 : 0, fmt::join(names, " "));
    if (run.times.empty()) {
      text += ",,,,,,,,,,,,,,\n";
      continue;
    }
    const auto [smallest, largest] = std::minmax_element(run.times.begin(), run.times.end());
    const SolveTimes& t = run.median;
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", run.iterations,
                        run.sweeps, t.total, *smallest, *largest, t.evaluate, t.differentiate,
                        t.sweep, t.rollout, cell(run.check.cost), cell(entry.cost_excess),
                        cell(run.check.stationarity), cell(run.check.gap),
                        cell(run.check.constraint), cell(run.check.complementarity));
  }
  return text;
}

namespace {

/// The points of a profile up to a ratio, one per line.
std::string points_text(const PerformanceProfile& profile, double last) {
  std::string text = "1 0\n";
  for (const auto& [ratio, share] : profile.steps) text += fmt::format("{} {}\n", ratio, share);
  return text + fmt::format("{} {}\n", last, profile.share(last));
}

}  // namespace

std::string profile_script(const BenchmarkReport& report) {
  std::string text =
      "set terminal svg size 860,380 font 'sans-serif,13' background '#ffffff'\n"
      "set multiplot layout 1,2\n"
      "set grid lc rgb '#dddddd'\n"
      "set logscale x 2\n"
      "set yrange [0:1.02]\n"
      "set key bottom right\n"
      "set ylabel 'share of problems solved'\n";
  for (const Effort effort : {Effort::time, Effort::iterations}) {
    const auto profiles = performance_profiles(report.request.solvers, efforts(report, effort));
    double last = 2;
    for (const PerformanceProfile& profile : profiles)
      if (!profile.steps.empty()) last = std::max(last, 1.2 * profile.steps.back().first);
    const char* what = effort == Effort::time ? "time" : "iterations";
    text += fmt::format("set xrange [1:{}]\nset xlabel 'at most so many times the {}'\n", last,
                        effort == Effort::time ? "shortest time" : "fewest iterations");
    std::string plots;
    for (std::size_t s = 0; s < profiles.size(); ++s) {
      text += fmt::format("${}{} << EOD\n{}EOD\n", what, s, points_text(profiles[s], last));
      plots += fmt::format("{}${}{} using 1:2 with steps lw 2 title '{}' noenhanced",
                           s == 0 ? "" : ", ", what, s, profiles[s].solver);
    }
    text += "plot " + plots + '\n';
  }
  return text + "unset multiplot\n";
}

}  // namespace conddp
