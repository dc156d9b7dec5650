#include "output/mpc/loop_files.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "base/files/atomic_file.hpp"
#include "base/json/ordered_json.hpp"
#include "output/solution/csv.hpp"
#include "output/solution/csv_cells.hpp"
#include "output/solution/solution_json.hpp"
#include "problem_file/expand/expand_problem.hpp"

namespace conddp {
namespace {

constexpr TickOutcome kOutcomes[] = {TickOutcome::planned,           TickOutcome::improved,
                                     TickOutcome::not_finite,        TickOutcome::late,
                                     TickOutcome::infeasible,        TickOutcome::diverged,
                                     TickOutcome::out_of_iterations, TickOutcome::no_step};

void append_time(double time, std::string& text) { append_cell(tabulated_time(time), text); }

void append_numbers(const std::vector<double>& numbers, std::string& text) {
  for (const double number : numbers) {
    text += ',';
    append_cell(number, text);
  }
}

/// The phase at a time; after the end of a held time line, the last phase.
std::string phase_at(const LoopRun& run, const TimeLine& line, double time) {
  const ShootingProblem& problem = *run.task.built.problem;
  return csv_cell(problem.phases()[problem.knot(line.at(time).knot).phase].name);
}

/// End time on the controller's time line.
double line_time_of_end(const ClosedLoopResult& result) {
  const double shift = result.ticks.empty() ? 0 : result.ticks.back().shift;
  return result.end_time + shift;
}

/// Figures of a tick's solve.
void append_solve(const TickRecord& tick, std::string& text) {
  if (!tick.solved) {
    text += ",,,,,,";
    return;
  }
  text += fmt::format(",{},{}", to_string(tick.status), tick.iterations);
  append_numbers({tick.cost, tick.stationarity, tick.gap, tick.violation}, text);
}

OrderedJson outcomes_json(const std::vector<TickRecord>& ticks) {
  OrderedJson json = OrderedJson::object();
  for (const TickOutcome outcome : kOutcomes)
    json[std::string(to_string(outcome))] =
        std::count_if(ticks.begin(), ticks.end(),
                      [&](const TickRecord& tick) { return tick.outcome == outcome; });
  return json;
}

OrderedJson last_state_json(const LoopRun& run) {
  OrderedJson json = OrderedJson::object();
  for (std::size_t i = 0; i < run.task.built.state_columns.size(); ++i)
    json[run.task.built.state_columns[i].name] = finite_or_null(run.result.last_state[i]);
  return json;
}

/// Commands that the controller received. A commanded gait appears in the configuration as phases.
OrderedJson commands_json(const MpcSpec& mpc) {
  OrderedJson list = OrderedJson::array();
  for (const GaitCommand& command : mpc.commands)
    list.push_back({{"at", command.at.value},
                    {"velocity", {command.x, command.y, 0}},
                    {"turn", command.turn}});
  return list;
}

OrderedJson dropped_json(const BuiltProblem& built) {
  OrderedJson names = OrderedJson::array();
  for (const DroppedConstraint& constraint : built.dropped) names.push_back(constraint.name);
  return names;
}

/// The ticks with late answers: an input of the loop like its file.
OrderedJson late_ticks_json(const std::vector<TickRecord>& ticks) {
  OrderedJson list = OrderedJson::array();
  for (const TickRecord& tick : ticks)
    if (tick.outcome == TickOutcome::late) list.push_back(tick.tick);
  return list;
}

OrderedJson problem_json(const LoopRun& run) {
  const ProblemFacts& facts = run.task.built.facts();
  const InputFiles files = input_files(run.task);
  return {{"name", facts.name.value},
          {"file", facts.file.string()},
          {"sha256", facts.sha256},
          {"robots", files_json(files.robots)},
          {"data_files", files_json(files.data)},
          {"overrides", run.overrides},
          {"configuration", expand_problem(run.task.built)}};
}

}  // namespace

double tabulated_time(double time) { return std::round(time * 1e9) / 1e9; }

std::string closed_loop_header(const LoopTask& task) {
  TableColumns all;
  all.states.resize(task.built.problem->nx());
  std::iota(all.states.begin(), all.states.end(), 0);
  return "t [s],phase" + column_headers(task.built, all) +
         contact_headers(no_plant_forces(task, 0));
}

std::string closed_loop_csv(const LoopRun& run) {
  const TimeLine line(run.task.built.problem, run.task.mpc.controller.hold);
  std::string text = closed_loop_header(run.task) + '\n';
  const ContactForces forces = plant_forces(run.task, run.result);
  const int rows = static_cast<int>(run.result.steps.size());
  for (int row = 0; row < rows; ++row) {
    const PlantStep& step = run.result.steps[row];
    append_time(step.time, text);
    text += ',' + phase_at(run, line, step.line_time);
    append_numbers(step.x, text);
    append_numbers(step.u, text);
    append_contact_cells(forces, row, true, text);
    text += '\n';
  }
  append_time(run.result.end_time, text);
  text += ',' + phase_at(run, line, line_time_of_end(run.result));
  append_numbers(run.result.last_state, text);
  text += std::string(run.task.built.control_columns.size(), ',');
  append_contact_cells(forces, rows, false, text);
  return text + '\n';
}

std::string ticks_csv(const LoopRun& run) {
  std::string text =
      "tick,t [s],outcome,status,iterations,cost,stationarity,gap,violation,plan_age "
      "[s],fallback,shift [s]\n";
  for (const TickRecord& tick : run.result.ticks) {
    text += fmt::format("{},", tick.tick);
    append_time(tick.time, text);
    text += fmt::format(",{}", to_string(tick.outcome));
    append_solve(tick, text);
    text += ',';
    append_time(tick.plan_age, text);
    text += tick.fallback ? ",1," : ",0,";
    append_time(tick.shift, text);
    text += '\n';
  }
  return text;
}

std::string tick_times_csv(const LoopRun& run) {
  std::string text = "tick,preparation [s],feedback [s]\n";
  for (const TickRecord& tick : run.result.ticks)
    text += fmt::format("{},{},{}\n", tick.tick, tick.preparation, tick.feedback);
  return text;
}

OrderedJson loop_json(const LoopRun& run) {
  const ClosedLoopResult& result = run.result;
  const auto fallbacks = std::count_if(result.ticks.begin(), result.ticks.end(),
                                       [](const TickRecord& tick) { return tick.fallback; });
  return {{"format", kMpcFormat},
          {"problem", problem_json(run)},
          {"tool", tool_json()},
          {"solver", run.task.mpc.controller.solver},
          {"clock", run.task.mpc.controller.clock ? "wall" : "simulated"},
          {"commands", commands_json(*run.task.built.facts().mpc)},
          {"end", to_string(result.end)},
          {"message", reason_of_end(run.task, result)},
          {"end_time_s", result.end_time},
          {"ticks", result.ticks.size()},
          {"outcomes", outcomes_json(result.ticks)},
          {"late_ticks", late_ticks_json(result.ticks)},
          {"fallback_ticks", fallbacks},
          {"cost", finite_or_null(result.cost)},
          {"violation", finite_or_null(result.violation)},
          {"dropped_constraints", dropped_json(run.task.built)},
          {"last_state", last_state_json(run)}};
}

std::vector<std::filesystem::path> add_loop(const LoopRun& run, const std::filesystem::path& folder,
                                            AtomicFiles& files) {
  std::vector<std::filesystem::path> paths = {folder / kLoopFile, folder / kPlantFile,
                                              folder / kTicksFile, folder / kTickTimesFile};
  files.add(paths[0], json_text(loop_json(run)));
  files.add(paths[1], closed_loop_csv(run));
  files.add(paths[2], ticks_csv(run));
  files.add(paths[3], tick_times_csv(run));
  return paths;
}

std::vector<std::filesystem::path> write_loop(const LoopRun& run,
                                              const std::filesystem::path& folder) {
  create_folder(folder);
  AtomicFiles files;
  std::vector<std::filesystem::path> paths = add_loop(run, folder, files);
  files.commit();
  return paths;
}
namespace {

/// The problem whose systems move the plant at a given time.
const ShootingProblem& moving_problem(const LoopTask& task, double time) {
  const PlantPeriod* period = period_at(task.mpc.loop.plant, time);
  return period != nullptr && period->problem ? *period->problem : *task.built.problem;
}

void copy_forces(const std::vector<double>& found, int row, ContactForces& to) {
  for (std::size_t c = 0; c < to.contacts.size() && 3 * c < found.size(); ++c)
    if (const double* f = found.data() + 3 * c; !std::isnan(f[0]))
      to.contacts[c].wrench[row] = {f[0], f[1], f[2], 0, 0, 0};
}

}  // namespace

ContactForces no_plant_forces(const LoopTask& task, int rows) {
  ContactForces forces = no_contact_forces(task.built, rows);
  for (ContactForces::OfContact& contact : forces.contacts) contact.torque = false;
  for (const CandidateSpec& candidate : task.built.facts().candidates)
    forces.contacts.push_back({.name = candidate.name.value,
                               .torque = false,
                               .wrench = {std::size_t(rows), std::nullopt}});
  return forces;
}

ContactForces plant_forces(const LoopTask& task, const ClosedLoopResult& result) {
  const int rows = static_cast<int>(result.steps.size());
  ContactForces forces = no_plant_forces(task, rows);
  if (forces.contacts.empty()) return forces;
  const TimeLine line(task.built.problem, task.mpc.controller.hold);
  ContactForceWriter writer;
  for (int row = 0; row < rows; ++row) {
    const PlantStep& step = result.steps[row];
    if (!step.contact_forces.empty()) {
      copy_forces(step.contact_forces, row, forces);
      continue;
    }
    const ShootingProblem& problem = moving_problem(task, step.time);
    writer.write(problem.knot(line.at(step.time).knot).model->system(), step.x.data(),
                 step.u.data(), row, forces);
  }
  return forces;
}

}  // namespace conddp
