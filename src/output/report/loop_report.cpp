#include "output/report/loop_report.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "base/json/ordered_json.hpp"
#include "output/mpc/loop_files.hpp"
#include "output/scene/motion_scene.hpp"

namespace conddp {
namespace {

/// Limits on the data that a page can draw at once.
constexpr int kMostPlans = 300, kMostPlanNodes = 9, kMostRows = 1500, kMostTicks = 20'000;

/// Indices from 0 to count − 1 with a constant step, always including the last one.
std::vector<int> thinned(int count, int most) {
  const int step = std::max(1, (count - 1 + most - 2) / (most - 1));
  std::vector<int> kept;
  for (int i = 0; i < count - 1; i += step) kept.push_back(i);
  if (count > 0) kept.push_back(count - 1);
  return kept;
}

/// A state of the plant at the beginning of a step, or the last state.
struct PlantRow {
  double time;
  const std::vector<double>* x;
  const std::vector<double>* u;  ///< null for the last state
  int step;                      ///< step that begins here
};

std::vector<PlantRow> rows_of(const ClosedLoopResult& result) {
  const int count = static_cast<int>(result.steps.size()) + 1;
  std::vector<PlantRow> rows;
  for (const int i : thinned(count, kMostRows))
    if (i + 1 < count)
      rows.push_back({result.steps[i].time, &result.steps[i].x, &result.steps[i].u, i});
    else
      rows.push_back({result.end_time, &result.last_state, nullptr, i});
  return rows;
}

/// States and controls as a trajectory. Controls of another size, of impulses, are 0.
Trajectory trajectory_of(const std::vector<const std::vector<double>*>& states, int nu,
                         const std::vector<const std::vector<double>*>& controls) {
  const int nodes = static_cast<int>(states.size());
  Trajectory trajectory(static_cast<int>(states.front()->size()), std::vector<int>(nodes - 1, nu));
  for (int k = 0; k < nodes; ++k)
    trajectory.x(k) = Eigen::Map<const Eigen::VectorXd>(states[k]->data(), trajectory.x(k).size());
  for (int k = 0; k + 1 < nodes; ++k)
    if (static_cast<int>(controls[k]->size()) == nu)
      trajectory.u(k) = Eigen::Map<const Eigen::VectorXd>(controls[k]->data(), nu);
  return trajectory;
}

/// Values as one list per column.
OrderedJson values_by_column(const std::vector<Column>& columns,
                             const std::vector<const std::vector<double>*>& values) {
  OrderedJson names = OrderedJson::array(), units = OrderedJson::array(),
              lists = OrderedJson::array();
  for (std::size_t c = 0; c < columns.size(); ++c) {
    names.push_back(columns[c].name);
    units.push_back(columns[c].unit);
    OrderedJson list = OrderedJson::array();
    for (const std::vector<double>* row : values) list.push_back(eight_digits((*row)[c]));
    lists.push_back(std::move(list));
  }
  return {{"names", names}, {"units", units}, {"values", lists}};
}

/// The force of each contact by row, in world axes; null while it is open.
OrderedJson forces_of_rows(const LoopRun& run, const std::vector<PlantRow>& rows) {
  OrderedJson json = OrderedJson::object();
  for (const auto& contact : plant_forces(run.task, run.result).contacts) {
    OrderedJson list = OrderedJson::array();
    for (const PlantRow& row : rows) {
      if (row.u == nullptr) continue;
      const auto& wrench = contact.wrench[row.step];
      OrderedJson force = nullptr;
      if (wrench)
        force = {eight_digits((*wrench)[0]), eight_digits((*wrench)[1]),
                 eight_digits((*wrench)[2])};
      list.push_back(std::move(force));
    }
    json[contact.name] = std::move(list);
  }
  return json;
}

/// Phases with their ranges of rows.
OrderedJson phases_of_rows(const LoopTask& task, const std::vector<PlantRow>& rows) {
  const TimeLine line(task.built.problem, task.mpc.controller.hold);
  const ShootingProblem& problem = *task.built.problem;
  OrderedJson phases = OrderedJson::array();
  int last = -1;
  for (std::size_t k = 0; k + 1 < rows.size(); ++k) {
    const int phase = problem.knot(line.at(rows[k].time).knot).phase;
    if (phase != last)
      phases.push_back({{"name", problem.phases()[phase].name}, {"first_knot", k}, {"knots", 0}});
    last = phase;
    phases.back()["knots"] = phases.back()["knots"].get<int>() + 1;
  }
  return phases;
}

/// Replaces the places of moving obstacles by one place per row.
void place_obstacles(const LoopTask& task, const std::vector<PlantRow>& rows, OrderedJson& scene) {
  if (!scene.is_object() || !scene.contains("obstacles")) return;
  const TimeLine line(task.built.problem, task.mpc.controller.hold);
  for (OrderedJson& obstacle : scene["obstacles"]) {
    if (!obstacle.contains("centers")) continue;
    const OrderedJson nodes = std::move(obstacle["centers"]);
    obstacle["centers"] = OrderedJson::array();
    for (const PlantRow& row : rows)
      for (int i = 0; i < 3; ++i)
        obstacle["centers"].push_back(
            nodes.at(static_cast<std::size_t>(3 * line.at(row.time).knot + i)));
  }
}

/// The problem's knots at these times.
std::vector<int> knots_at(const LoopTask& task, const std::vector<double>& times) {
  const TimeLine line(task.built.problem, task.mpc.controller.hold);
  std::vector<int> knots;
  for (const double time : times) knots.push_back(line.at(time).knot);
  return knots;
}

OrderedJson plant_json(const LoopRun& run) {
  const LoopTask& task = run.task;
  const std::vector<PlantRow> rows = rows_of(run.result);
  OrderedJson t = OrderedJson::array();
  std::vector<double> times;
  std::vector<const std::vector<double>*> x, u;
  for (const PlantRow& row : rows) {
    times.push_back(row.time);
    t.push_back(eight_digits(row.time));
    x.push_back(row.x);
    if (row.u != nullptr) u.push_back(row.u);
  }
  OrderedJson scene = motion_scene(
      task.built, trajectory_of(x, static_cast<int>(task.built.control_columns.size()), u),
      knots_at(task, times));
  place_obstacles(task, rows, scene);
  return {{"label", "plant"},
          {"remark", ""},
          {"head", loop_json(run)},
          {"curves",
           {{"t", t},
            {"phases", phases_of_rows(task, rows)},
            {"x", values_by_column(task.built.state_columns, x)},
            {"u", values_by_column(task.built.control_columns, u)},
            {"contact_forces", forces_of_rows(run, rows)}}},
          {"scene", std::move(scene)}};
}

OrderedJson ticks_json(const std::vector<TickRecord>& ticks) {
  OrderedJson json = OrderedJson::object();
  for (const char* key :
       {"t", "preparation_ms", "feedback_ms", "cost", "violation", "gap", "plan_age"})
    json[key] = OrderedJson::array();
  for (const int i : thinned(static_cast<int>(ticks.size()), kMostTicks)) {
    const TickRecord& tick = ticks[i];
    const auto add = [&](const char* key, double value) {
      json[key].push_back(eight_digits(value));
    };
    add("t", tick.time);
    add("preparation_ms", 1e3 * tick.preparation);
    add("feedback_ms", 1e3 * tick.feedback);
    add("plan_age", tick.plan_age);
    const std::pair<const char*, double> of_solve[] = {
        {"cost", tick.cost}, {"violation", tick.violation}, {"gap", tick.gap}};
    for (const auto& [key, value] : of_solve)
      json[key].push_back(tick.solved ? eight_digits(value) : OrderedJson());
  }
  return json;
}

/// Events over time, in rows of the time line.
class Events {
 public:
  explicit Events(const LoopRun& run) : run_(run) {}

  OrderedJson json() {
    const auto outcome = [](const TickRecord& tick) {
      return tick.outcome == TickOutcome::planned ? std::string()
                                                  : std::string(to_string(tick.outcome));
    };
    const auto fallback = [](const TickRecord& tick) {
      return std::string(tick.fallback ? "fallback" : "");
    };
    add_disturbances();
    add_runs("failed ticks", outcome);
    add_runs("fallback", fallback);
    if (run_.result.end != LoopEnd::finished)
      add("end", run_.result.end_time, run_.result.end_time,
          std::string(to_string(run_.result.end)));
    return std::move(list_);
  }

 private:
  void add(const char* row, double from, double to, const std::string& text) {
    list_.push_back(
        {{"row", row}, {"from", eight_digits(from)}, {"to", eight_digits(to)}, {"text", text}});
  }

  void add_disturbances() {
    for (const DisturbanceSpec& disturbance : run_.task.built.facts().mpc->disturbances) {
      const double at = disturbance.at.value;
      if (at > run_.result.end_time) continue;
      if (disturbance.jump) add("disturbances", at, at, "jump");
      if (disturbance.push)
        add("disturbances", at, std::min(at + disturbance.duration, run_.result.end_time),
            "push on " + disturbance.push->frame.value);
    }
  }

  /// Consecutive ticks with the same text form one event.
  template <class Text>
  void add_runs(const char* row, Text text_of) {
    const auto& ticks = run_.result.ticks;
    for (std::size_t i = 0; i < ticks.size();) {
      const std::string text = text_of(ticks[i]);
      const std::size_t first = i;
      while (i < ticks.size() && text_of(ticks[i]) == text) ++i;
      const double to = i < ticks.size() ? ticks[i].time : run_.result.end_time;
      if (!text.empty())
        add(row, ticks[first].time, to,
            fmt::format("{}, {} tick{}", text, i - first, i - first == 1 ? "" : "s"));
    }
  }

  const LoopRun& run_;
  OrderedJson list_ = OrderedJson::array();
};

/// Bodies at the nodes of all plans, concatenated, and the path of the center of mass or of the
/// first body.
OrderedJson plans_json(const LoopTask& task, const std::vector<RecordedPlan>& plans) {
  OrderedJson list = OrderedJson::array();
  std::vector<const std::vector<double>*> states, controls;
  std::vector<double> times;
  for (const RecordedPlan& plan : plans) {
    times.insert(times.end(), plan.times.begin(), plan.times.end());
    list.push_back(
        {{"from", eight_digits(plan.from)},
         {"first", states.size()},
         {"nodes", plan.x.size()},
         {"until", plan.times.empty() ? OrderedJson() : eight_digits(plan.times.back())}});
    for (const std::vector<double>& x : plan.x) states.push_back(&x);
    for (const std::vector<double>& u : plan.u) controls.push_back(&u);
  }
  OrderedJson json = {{"list", std::move(list)}, {"poses", nullptr}, {"track", nullptr}};
  if (states.empty()) return json;
  OrderedJson scene = motion_scene(
      task.built,
      trajectory_of(states, static_cast<int>(task.built.control_columns.size()), controls),
      knots_at(task, times));
  if (scene.is_null() || (scene["com"].empty() && scene["paths"].empty())) return json;
  json["poses"] = std::move(scene["poses"]);
  json["track"] =
      scene["com"].empty() ? std::move(scene["paths"].front()) : std::move(scene["com"]);
  return json;
}

int ticks_of(const LoopTask& task) {
  return static_cast<int>(std::ceil(task.mpc.loop.duration / task.mpc.controller.tick));
}

}  // namespace

PlanRecorder::PlanRecorder(const LoopTask& task)
    : every_(std::max(1, (ticks_of(task) + kMostPlans - 1) / kMostPlans)) {}

void PlanRecorder::record(const Mpc& mpc) {
  if (mpc.last_tick().tick % every_ != 0) return;
  RecordedPlan& kept = plans_.emplace_back();
  kept.from = mpc.last_tick().time;
  const Plan* plan = mpc.plan();
  if (plan == nullptr) return;
  for (const int k : thinned(plan->trajectory.knots() + 1, kMostPlanNodes)) {
    kept.times.push_back(plan->times[k]);
    const auto x = plan->trajectory.x(k);
    const auto u = plan->trajectory.u(std::min(k, plan->trajectory.knots() - 1));
    kept.x.emplace_back(x.data(), x.data() + x.size());
    kept.u.emplace_back(u.data(), u.data() + u.size());
  }
}

OrderedJson loop_report(const LoopRun& run, const std::vector<RecordedPlan>& plans) {
  OrderedJson solutions = OrderedJson::array();
  solutions.push_back(plant_json(run));
  return {{"format", "conddp.report/1"},
          {"solutions", std::move(solutions)},
          {"loop",
           {{"ticks", ticks_json(run.result.ticks)},
            {"events", Events(run).json()},
            {"plans", plans_json(run.task, plans)}}}};
}

}  // namespace conddp
