#include "output/mpc/loop_task.hpp"

#include <fmt/format.h>

#include "mpc/appraisal.hpp"
#include "output/solution/solved_problem.hpp"

namespace conddp {
namespace {

/// A sentence that names the first violated condition of stop_when in a state.
std::string broken_condition(const LoopTask& task, const double* x) {
  const StopCheck check(task.mpc.loop.stop);
  const ConstraintTerm* broken = check.first_met(x);
  return fmt::format("the condition '{}' of stop_when does not hold",
                     broken != nullptr ? broken->name : "");
}

}  // namespace

std::unique_ptr<LoopTask> rebuild_loop(const OrderedJson& document, const std::string& file,
                                       const std::filesystem::path& problem, Diagnostics& out) {
  std::unique_ptr<LoopTask> task;
  const auto build = [&](const ProblemDocument& read, const std::vector<Setting>& settings,
                         const BuildOptions& options,
                         Diagnostics& own) -> std::optional<InputFiles> {
    task = build_loop(read_problem(read, settings, own), options, own);
    return task ? std::optional(input_files(*task)) : std::nullopt;
  };
  if (!build_again(RebuiltFor::kLoop, document, file, problem, build, out)) return nullptr;
  return task;
}

InputFiles input_files(const LoopTask& task) {
  InputFiles files = input_files(task.built);
  files.data.insert(files.data.end(), task.mpc.plant_files.begin(), task.mpc.plant_files.end());
  return files;
}

std::string reason_of_end(const LoopTask& task, const ClosedLoopResult& result) {
  switch (result.end) {
    case LoopEnd::finished:
      break;
    case LoopEnd::stopped:
      return broken_condition(task, result.last_state.data());
    case LoopEnd::diverged:
      return result.failure.empty()
                 ? "the plant's state is not finite"
                 : fmt::format("{} at {:g} s", result.failure, result.steps.back().time);
    case LoopEnd::interrupted:
      return "a signal or the limit of time ended it";
  }
  return {};
}

ClosedLoopResult run_loop(const LoopTask& task, std::function<void(const Mpc&)> observe) {
  Mpc mpc(task.built.problem, task.built.guess, task.mpc.controller);
  ClosedLoopOptions options = task.mpc.loop;
  options.observe = std::move(observe);
  return run_closed_loop(mpc, options);
}

}  // namespace conddp
