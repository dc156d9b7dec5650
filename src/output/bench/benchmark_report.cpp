#include "output/bench/benchmark_report.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "analysis/comparison/solution_comparison.hpp"

namespace conddp {
namespace {

std::string constraints_left_out(const BenchmarkEntry& entry) {
  std::string names;
  for (const LeftOut& constraint : entry.left_out) names += constraint.name + '\n';
  return names;
}

using InstanceKey = std::pair<std::string, std::optional<std::uint64_t>>;

InstanceKey instance_of(const BenchmarkEntry& entry) { return {entry.file, entry.seed}; }

}  // namespace

void compare_costs(BenchmarkReport& report) {
  struct Group {
    double lowest = std::numeric_limits<double>::infinity();
    int answers = 0;
  };
  // Different guesses belong to the same problem; different initial states make different problems.
  std::map<std::tuple<std::string, std::vector<double>, std::string>, Group> groups;
  const auto group_of = [&](const BenchmarkEntry& entry) -> Group& {
    return groups[{entry.file, entry.initial_state, constraints_left_out(entry)}];
  };
  for (const BenchmarkEntry& entry : report.entries) {
    if (!entry.run.solved) continue;
    Group& group = group_of(entry);
    group.lowest = std::min(group.lowest, entry.run.check.cost);
    ++group.answers;
  }
  for (BenchmarkEntry& entry : report.entries) {
    if (!entry.run.solved) continue;
    const Group& group = group_of(entry);
    if (!entry.best_known && group.answers < 2) continue;
    const double best = entry.best_known.value_or(group.lowest);
    entry.cost_excess = (entry.run.check.cost - best) / std::max(std::abs(best), kSmallestCostSize);
  }
}

bool all_kept_word(const BenchmarkReport& report) {
  return std::all_of(report.entries.begin(), report.entries.end(),
                     [](const BenchmarkEntry& entry) { return entry.run.kept_word(); });
}

namespace {

/// Adds a run of a supported problem.
void add_run(const BenchmarkEntry& entry, SolverSummary& summary,
             std::map<std::string, int>& failures) {
  ++summary.runs;
  (entry.left_out.empty() ? summary.solved : summary.solved_without) += entry.run.solved;
  summary.left_out += !entry.left_out.empty();
  if (!entry.run.solved) {
    ++failures[entry.run.kept_word() ? entry.run.status : "check failed"];
    return;
  }
  if (!entry.left_out.empty()) return;
  for (std::size_t i = 0; i < kCostLevels.size(); ++i)
    summary.within[i] += !(entry.cost_excess > kCostLevels[i].excess);
}

}  // namespace

std::vector<SolverSummary> summarize(const BenchmarkReport& report) {
  std::vector<SolverSummary> list;
  for (const std::string& solver : report.request.solvers) {
    SolverSummary summary{.solver = solver};
    std::map<std::string, int> failures;
    for (const BenchmarkEntry& entry : report.entries) {
      if (entry.run.solver != solver) continue;
      if (entry.run.status == "refused")
        ++summary.refused;
      else
        add_run(entry, summary, failures);
    }
    summary.failures.assign(failures.begin(), failures.end());
    std::stable_sort(summary.failures.begin(), summary.failures.end(),
                     [](const auto& a, const auto& b) { return a.second > b.second; });
    list.push_back(std::move(summary));
  }
  return list;
}

std::vector<std::vector<double>> efforts(const BenchmarkReport& report, Effort effort) {
  const std::vector<std::string>& names = report.request.solvers;
  std::vector<InstanceKey> instances;
  std::vector<std::vector<double>> rows;
  for (const BenchmarkEntry& entry : report.entries) {
    if (instances.empty() || instances.back() != instance_of(entry)) {
      instances.push_back(instance_of(entry));
      rows.emplace_back(names.size(), std::numeric_limits<double>::infinity());
    }
    if (!entry.run.solved || !entry.left_out.empty()) continue;
    const auto solver = std::find(names.begin(), names.end(), entry.run.solver) - names.begin();
    rows.back()[solver] = effort == Effort::time         ? entry.run.median.total
                          : effort == Effort::iterations ? entry.run.iterations
                                                         : entry.run.sweeps;
  }
  return rows;
}

}  // namespace conddp
