#include <fstream>
#include <thread>

#include "analysis/comparison/benchmark.hpp"
#include "output/bench/benchmark_report.hpp"
#include "output/solution/solution_json.hpp"

namespace conddp {
namespace {

/// The name of the processor, empty if the system does not report it.
std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name"))
      return line.substr(std::min(line.find(':') + 2, line.size()));
  return {};
}

OrderedJson request_json(const BenchmarkRequest& request) {
  return {{"solvers", request.solvers},
          {"repeat", request.repeat},
          {"instances", request.instances},
          {"seed", request.seed},
          {"perturb",
           {{"initial_state", request.initial_state_size.value_or(0)},
            {"guess", request.guess_spread.value_or(0)}}},
          {"drop", request.drop},
          {"overrides", request.settings},
          {"tolerances", request.tolerances}};
}

OrderedJson residuals(double stationarity, double gap, double constraint, double complementarity) {
  return {{"stationarity", finite_or_null(stationarity)},
          {"gap", finite_or_null(gap)},
          {"constraint", finite_or_null(constraint)},
          {"complementarity", finite_or_null(complementarity)}};
}

OrderedJson time_json(const BenchmarkRun& run) {
  return {{"median", run.median.total},
          {"evaluate", run.median.evaluate},
          {"differentiate", run.median.differentiate},
          {"sweep", run.median.sweep},
          {"rollout", run.median.rollout},
          {"spread", finite_or_null(run.spread())},
          {"solves", run.times}};
}

OrderedJson entry_json(const BenchmarkEntry& entry) {
  const BenchmarkRun& run = entry.run;
  OrderedJson dropped = OrderedJson::array();
  for (const LeftOut& constraint : entry.left_out)
    dropped.push_back(
        {{"name", constraint.name}, {"violation", finite_or_null(constraint.violation)}});
  OrderedJson json = {{"problem", entry.problem}, {"file", entry.file},
                      {"sha256", entry.sha256},   {"problem_sha256", entry.problem_sha256},
                      {"command", entry.command}, {"knots", entry.knots},
                      {"states", entry.states},   {"controls", entry.controls},
                      {"seed", nullptr},          {"initial_state", entry.initial_state},
                      {"solver", run.solver},     {"status", run.status},
                      {"message", run.message},   {"solved", run.solved && entry.left_out.empty()}};
  if (entry.seed) json["seed"] = *entry.seed;
  json["dropped_constraints"] = std::move(dropped);
  json["options"] = entry.options;
  if (run.status == "refused") return json;
  json["iterations"] = run.iterations;
  json["sweeps"] = run.sweeps;
  json["cost"] = finite_or_null(run.check.cost);
  json["best_known"] = nullptr;
  if (entry.best_known) json["best_known"] = *entry.best_known;
  json["cost_excess"] = finite_or_null(entry.cost_excess);
  json["residuals"] = residuals(run.check.stationarity, run.check.gap, run.check.constraint,
                                run.check.complementarity);
  json["claimed_residuals"] = residuals(run.claimed.stationarity, run.claimed.gap,
                                        run.claimed.constraint, run.claimed.complementarity);
  json["time_s"] = time_json(run);
  return json;
}

OrderedJson summary_json(const BenchmarkReport& report) {
  OrderedJson list = OrderedJson::array();
  for (const SolverSummary& summary : summarize(report)) {
    OrderedJson failures = OrderedJson::object();
    for (const auto& [status, count] : summary.failures) failures[status] = count;
    OrderedJson within = OrderedJson::object();
    for (std::size_t i = 0; i < kCostLevels.size(); ++i)
      within[kCostLevels[i].name] = summary.within[i];
    list.push_back({{"solver", summary.solver},
                    {"runs", summary.runs},
                    {"solved", summary.solved},
                    {"within", std::move(within)},
                    {"with_dropped_constraints", summary.left_out},
                    {"solved_with_dropped_constraints", summary.solved_without},
                    {"refused", summary.refused},
                    {"failures", std::move(failures)}});
  }
  return list;
}

OrderedJson profiles_json(const std::vector<PerformanceProfile>& profiles) {
  OrderedJson json = OrderedJson::object();
  for (const PerformanceProfile& profile : profiles) json[profile.solver] = profile.steps;
  return json;
}

}  // namespace

OrderedJson benchmark_json(const BenchmarkReport& report) {
  OrderedJson runs = OrderedJson::array();
  for (const BenchmarkEntry& entry : report.entries) runs.push_back(entry_json(entry));
  const std::vector<std::string>& solvers = report.request.solvers;
  const auto against_best = [&](Effort effort) {
    return profiles_json(performance_profiles(solvers, efforts(report, effort)));
  };
  return {{"format", "conddp.bench/1"},
          {"tool", tool_json()},
          {"machine",
           {{"processor", processor_name()},
            {"logical_processors", std::thread::hardware_concurrency()}}},
          {"request", request_json(report.request)},
          {"runs", std::move(runs)},
          {"summary", summary_json(report)},
          {"profiles",
           {{"time", against_best(Effort::time)},
            {"iterations", against_best(Effort::iterations)},
            {"sweeps", profiles_json(data_profiles(solvers, efforts(report, Effort::sweeps)))}}}};
}

}  // namespace conddp
