#include "batch/run/simulate_item.hpp"

#include <algorithm>
#include <chrono>

#include <fmt/format.h>

#include "output/mpc/loop_files.hpp"
#include "solvers/common/status.hpp"

namespace conddp {
namespace {

std::string_view status_of(LoopEnd end) {
  return end == LoopEnd::interrupted ? to_string(SolveStatus::time_limit) : to_string(end);
}

/// The fraction of ticks that satisfy a predicate.
template <class Holds>
double share_of(const std::vector<TickRecord>& ticks, Holds holds) {
  if (ticks.empty()) return 0;
  return static_cast<double>(std::count_if(ticks.begin(), ticks.end(), holds)) /
         static_cast<double>(ticks.size());
}

/// The figures of a loop for the row of results.
OrderedJson answer_of(const LoopTask& task, const ClosedLoopResult& result) {
  const auto is_planned = [](const TickRecord& t) { return t.outcome == TickOutcome::planned; };
  const auto falls_back = [](const TickRecord& t) { return t.fallback; };
  return {{"solver", task.mpc.controller.solver},
          {"time_s", tabulated_time(result.end_time)},
          {"planned", share_of(result.ticks, is_planned)},
          {"fallback", share_of(result.ticks, falls_back)},
          {"cost", finite_or_null(result.cost)},
          {"violation", finite_or_null(result.violation)},
          {"message", reason_of_end(task, result)}};
}

}  // namespace

SolvedItem simulate_item(const ManifestItem& item, const Manifest& manifest,
                         const ProblemFamily& family) {
  const auto began = std::chrono::steady_clock::now();
  const auto seconds = [began] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  };
  Diagnostics diagnostics = family.texts();
  const std::vector<Setting> settings = settings_of(item, diagnostics);
  const auto task = family.build_loop(settings, diagnostics);
  if (!task || item_id(manifest, item.problem, settings, input_files(*task)) != item.id)
    return {not_built(item, diagnostics), {}, {}};
  const double built = seconds(), limit = manifest.limits.max_time_s;
  task->mpc.controller.solver_options.threads = 1;
  if (limit > 0) task->mpc.loop.interrupted = [&] { return seconds() > built + limit; };
  const ClosedLoopResult result = run_loop(*task);
  return {{.id = item.id,
           .status = std::string(status_of(result.end)),
           .success = result.end == LoopEnd::finished,
           .answer = answer_of(*task, result),
           .times = {{"build", built}, {"solve", seconds() - built}, {"all", seconds()}}},
          {},
          {}};
}

}  // namespace conddp
