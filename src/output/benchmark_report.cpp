#include "output/benchmark_report.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

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

void compare_costs(std::vector<BenchmarkEntry>& entries) {
  std::map<std::pair<InstanceKey, std::string>, double> best;
  const auto key = [](const BenchmarkEntry& entry) {
    return std::pair(instance_of(entry), constraints_left_out(entry));
  };
  for (const BenchmarkEntry& entry : entries) {
    if (!entry.run.solved) continue;
    const auto [found, fresh] = best.try_emplace(key(entry), entry.run.check.cost);
    if (!fresh) found->second = std::min(found->second, entry.run.check.cost);
  }
  for (BenchmarkEntry& entry : entries) {
    if (!entry.run.solved) continue;
    const double lowest = best.at(key(entry));
    entry.cost_excess = entry.run.check.cost == lowest
                            ? 0
                            : (entry.run.check.cost - lowest) / std::max(std::abs(lowest), 1e-300);
  }
}

bool all_kept_word(const BenchmarkReport& report) {
  return std::all_of(report.entries.begin(), report.entries.end(),
                     [](const BenchmarkEntry& entry) { return entry.run.kept_word(); });
}

std::vector<SolverSummary> summarize(const BenchmarkReport& report) {
  std::vector<SolverSummary> list;
  for (const std::string& solver : report.request.solvers) {
    SolverSummary summary{.solver = solver};
    std::map<std::string, int> failures;
    for (const BenchmarkEntry& entry : report.entries) {
      if (entry.run.solver != solver) continue;
      if (entry.run.status == "refused") {
        ++summary.refused;
        continue;
      }
      ++summary.runs;
      summary.solved += entry.run.solved;
      summary.left_out += !entry.left_out.empty();
      if (!entry.run.solved) ++failures[entry.run.kept_word() ? entry.run.status : "check failed"];
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
    rows.back()[solver] = effort == Effort::time ? entry.run.median.total : entry.run.iterations;
  }
  return rows;
}

}  // namespace conddp
