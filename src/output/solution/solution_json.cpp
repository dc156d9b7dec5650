#include "output/solution/solution_json.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include <fmt/format.h>

#include "base/files/atomic_file.hpp"
#include "base/json/json_document.hpp"
#include "base/json/ordered_json.hpp"
#include "conddp_version.hpp"
#include "ocp/problem/by_name.hpp"
#include "ocp/problem/cost_scale.hpp"
#include "output/solution/csv.hpp"
#include "output/solution/finding_report.hpp"
#include "output/solution/free_numbers.hpp"
#include "output/solution/input_files.hpp"
#include "output/solution/log_columns.hpp"
#include "output/solution/npz.hpp"
#include "problem_file/expand/expand_problem.hpp"
#include "spatial/lane.hpp"

namespace conddp {
namespace {

OrderedJson numbers(std::span<const double> values) {
  OrderedJson::array_t list;
  list.reserve(values.size());
  for (const double value : values) list.push_back(finite_or_null(value));
  return list;
}
OrderedJson numbers(const Eigen::Ref<const Eigen::VectorXd>& values) {
  return numbers(std::span(values.data(), static_cast<std::size_t>(values.size())));
}

/// A list of rows, made by row(i).
template <class Row>
OrderedJson rows(Eigen::Index count, Row row) {
  OrderedJson list = OrderedJson::array();
  for (Eigen::Index i = 0; i < count; ++i) list.push_back(row(static_cast<int>(i)));
  return list;
}

/// Rows of the table of all controls, from each knot's own controls.
template <class Own>
OrderedJson control_rows(const ShootingProblem& problem, Own own) {
  const ControlColumns controls(problem);
  return rows(problem.knots(), [&](int k) { return numbers(controls.row(k, own(k))); });
}

OrderedJson problem_json(const Solution& s) {
  const InputFiles files = input_files(s.built);
  const ProblemFacts& facts = s.built.facts();
  OrderedJson json = json_object(10);
  json["name"] = facts.name.value;
  json["file"] = facts.file.string();
  json["sha256"] = facts.sha256;
  json["robots"] = files_json(files.robots);
  json["data_files"] = files_json(files.data);
  json["overrides"] = s.overrides;
  json["knots"] = s.built.problem->knots();
  json["duration_s"] = s.built.problem->times(s.result.trajectory).back();
  json["options"] = expand_options(facts.solver.options);
  json["configuration"] = expand_problem(s.built);
  return json;
}

OrderedJson residuals_json(const Residuals& r) {
  return {{"stationarity", finite_or_null(r.stationarity)},
          {"gap", finite_or_null(r.gap)},
          {"constraint", finite_or_null(r.constraint)},
          {"complementarity", finite_or_null(r.complementarity)}};
}

OrderedJson mesh_json(const Solution& s) {
  OrderedJson rounds = OrderedJson::array();
  for (const MeshRound& round : s.mesh)
    rounds.push_back({{"knots", round.knots},
                      {"error", finite_or_null(round.error)},
                      {"status", to_string(round.status)},
                      {"iterations", round.iterations},
                      {"cost", finite_or_null(round.cost)}});
  return {{"asked", s.built.facts().mesh->error},
          {"error", finite_or_null(s.mesh.back().error)},
          {"rounds", std::move(rounds)}};
}

OrderedJson guess_json(const Solution& s) {
  OrderedJson guess = {{"states", s.built.guess_used.states},
                       {"controls", s.built.guess_used.controls},
                       {"multipliers", s.built.guess_used.multipliers},
                       {"seed", nullptr},
                       {"used", s.result.start}};
  if (s.built.guess_used.seed) guess["seed"] = *s.built.guess_used.seed;
  return guess;
}

OrderedJson columns_json(const std::vector<Column>& columns, std::string Column::*member) {
  OrderedJson array = OrderedJson::array();
  for (const Column& column : columns) array.push_back(column.*member);
  return array;
}

OrderedJson contact_forces_json(const Solution& s) {
  OrderedJson json = json_object(s.answer.forces.contacts.size());
  for (const auto& contact : s.answer.forces.contacts) {
    OrderedJson rows = OrderedJson::array();
    for (const auto& wrench : contact.wrench)
      rows.push_back(wrench ? numbers(std::span(*wrench).first(contact.torque ? 6 : 3))
                            : OrderedJson(nullptr));
    json[contact.name] = std::move(rows);
  }
  return json;
}

OrderedJson trajectory_json(const Solution& s) {
  const ShootingProblem& problem = *s.built.problem;
  const Trajectory& trajectory = s.result.trajectory;
  OrderedJson json = motion_names(s.built);
  json["t"] = problem.times(trajectory);
  json["x"] = rows(problem.knots() + 1, [&](int k) { return numbers(trajectory.x(k)); });
  json["u"] = control_rows(problem, [&](int k) { return trajectory.u(k); });
  json["contact_forces"] = contact_forces_json(s);
  return json;
}

OrderedJson gains_json(const ShootingProblem& problem, const SolveResult& result) {
  const ControlColumns controls(problem);
  OrderedJson gains = json_object(3);
  gains["regularization"] = nullptr;
  if (result.feedback_regularization) gains["regularization"] = *result.feedback_regularization;
  gains["k"] = control_rows(
      problem, [&](int k) -> auto& { return result.feedback.k[k]; });
  gains["K"] = rows(problem.knots(), [&](int k) {
    const Eigen::MatrixXd K = controls.rows(k, result.feedback.K[k]).transpose();
    return rows(K.cols(), [&](int i) { return numbers(K.col(i)); });
  });
  return gains;
}

OrderedJson matrix_json(const Eigen::MatrixXd& columns) {
  return rows(columns.cols(), [&](int k) { return numbers(columns.col(k)); });
}

OrderedJson violations_json(const std::vector<ConstraintViolation>& violations) {
  OrderedJson list = OrderedJson::array();
  for (const ConstraintViolation& v : violations)
    list.push_back({{"name", v.name}, {"violation", finite_or_null(v.value)}, {"node", v.node}});
  return list;
}

OrderedJson constraint_multipliers(const Solution& s) {
  OrderedJson list = OrderedJson::array();
  for (const NodeConstraint& c : s.built.problem->constraints())
    list.push_back(
        {{"name", c.term->name},
         {"node", c.node},
         {"value", numbers(s.result.constraint_values.segment(c.row, c.term->rows))},
         {"multiplier", numbers(s.result.constraint_multipliers.segment(c.row, c.term->rows))}});
  return list;
}

OrderedJson multipliers_json(const Solution& s) {
  OrderedJson multipliers = json_object(5);
  multipliers["costates"] = matrix_json(s.result.costates);
  multipliers["state_gradient"] = matrix_json(s.result.state_gradient);
  if (s.built.problem->has_control_bounds() &&
      static_cast<int>(s.result.control_gradient.size()) == s.built.problem->knots()) {
    const auto of_bounds = [&](bool upper) {
      const auto own = bound_multipliers(*s.built.problem, s.result, upper);
      return control_rows(
          *s.built.problem, [&](int k) -> auto& { return own[k]; });
    };
    multipliers["control_lower"] = of_bounds(false);
    multipliers["control_upper"] = of_bounds(true);
  }
  if (!s.built.problem->constraints().empty())
    multipliers["constraints"] = constraint_multipliers(s);
  return multipliers;
}

OrderedJson log_json(const std::vector<IterationRecord>& log) {
  std::vector<std::string> names;
  for (const LogColumn& column : log_columns()) names.push_back(log_key(column));
  OrderedJson rows = OrderedJson::array();
  for (const IterationRecord& record : log) {
    // Appends entries directly: insertion by key would search the existing ones.
    OrderedJson row = json_object(names.size());
    auto& entries = row.get_ref<OrderedJson::object_t&>();
    for (std::size_t i = 0; i < names.size(); ++i) {
      const LogColumn& column = log_columns()[i];
      const double value = column.get(record);
      entries.emplace_back(names[i], column.integer ? OrderedJson(static_cast<long long>(value))
                                                    : finite_or_null(value));
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

/// The null numbers, by key, with their reasons: JSON cannot represent non-finite numbers.
OrderedJson nulls_json(const OrderedJson& json, const Solution& s) {
  const SolveResult& result = s.result;
  const std::string ended =
      fmt::format("the solve ended as '{}': {}", to_string(result.status), result.message);
  OrderedJson list = OrderedJson::array();
  const auto add = [&](const std::string& key, const OrderedJson& value,
                       const std::string& reason) {
    if (const int count = count_nulls(value); count > 0)
      list.push_back({{"key", key}, {"count", count}, {"reason", reason}});
  };
  const std::string unknown = "not finite, or not evaluated because " + ended;
  const std::string lacks = "a control that the system of the phase lacks";
  const std::string of_controls = s.built.plant.variants.empty() ? unknown
                                  : is_success(result.status)    ? lacks
                                                                 : lacks + ", or " + unknown;
  add("problem.options.max_time_s", json["problem"]["options"]["max_time_s"], "without limit");
  add("cost", json["cost"], unknown);
  add("cost_by_name", json["cost_by_name"], unknown);
  if (json.contains("free_numbers")) add("free_numbers", json["free_numbers"], unknown);
  add("residuals", json["residuals"], unknown);
  add("initial_guess_used.seed", json["initial_guess_used"]["seed"], "nothing is random");
  add("constraints", json["constraints"], unknown);
  add("soft_constraints", json["soft_constraints"], unknown);
  add("dropped_constraints", json["dropped_constraints"], unknown);
  if (json.contains("mesh"))
    add("mesh", json["mesh"], "the replay on a finer grid is not finite, or there is none");
  if (json.contains("homotopy"))
    add("homotopy", json["homotopy"], "of a problem without an iterate");
  if (!json.contains("trajectory")) return list;
  add("trajectory.x", json["trajectory"]["x"], unknown);
  add("trajectory.u", json["trajectory"]["u"], of_controls);
  add("trajectory.contact_forces", json["trajectory"]["contact_forces"],
      "the contact is not held at that knot");
  add("gains.regularization", json["gains"]["regularization"],
      "no sweep succeeded at the trajectory, the gains are zero: " + ended);
  add("gains.k", json["gains"]["k"], of_controls);
  add("gains.K", json["gains"]["K"], of_controls);
  add("multipliers", json["multipliers"], of_controls);
  add("log", json["log"], "not finite, or without meaning in its row");
  return list;
}

OrderedJson homotopy_json(const std::vector<HomotopyStep>& steps) {
  OrderedJson list = OrderedJson::array();
  for (const HomotopyStep& step : steps)
    list.push_back({{"share", step.share},
                    {"status", to_string(step.status)},
                    {"iterations", step.iterations},
                    {"cost", finite_or_null(step.cost)},
                    {"time_s", step.time_s}});
  return list;
}

OrderedJson restarts_json(const RestartRecord& restarts) {
  OrderedJson optima = OrderedJson::array();
  for (const Basin& basin : restarts.basins)
    optima.push_back({{"cost", basin.cost}, {"starts", basin.starts}, {"first", basin.first}});
  return {{"starts", restarts.starts},
          {"converged", restarts.converged},
          {"answer", restarts.answer},
          {"optima", std::move(optima)}};
}

OrderedJson attempts_json(const std::vector<Attempt>& attempts) {
  OrderedJson list = OrderedJson::array();
  for (const Attempt& a : attempts)
    list.push_back({{"solver", a.solver},
                    {"start", a.start},
                    {"status", to_string(a.status)},
                    {"iterations", a.iterations},
                    {"cost", finite_or_null(a.cost)},
                    {"time_s", a.time_s},
                    {"objection", a.objection},
                    {"chosen", a.chosen}});
  return list;
}

OrderedJson free_numbers_json(const std::vector<FreeNumber>& numbers) {
  OrderedJson list = OrderedJson::array();
  for (const FreeNumber& number : numbers)
    list.push_back({{"name", number.name},
                    {"value", finite_or_null(number.value)},
                    {"unit", number.unit},
                    {"limit", number.limit}});
  return list;
}

/// A solution.json with its certificate has 29 members.
constexpr std::size_t kMostMembers = 32;

OrderedJson head(const Solution& s) {
  const SolveResult& r = s.result;
  const Answer& answer = s.answer;
  OrderedJson costs = OrderedJson::object();
  for (const auto& [name, value] : answer.costs) costs[name] = finite_or_null(value);
  OrderedJson dropped = OrderedJson::array();
  for (const auto& [name, value] : answer.dropped)
    dropped.push_back({{"name", name}, {"violation", finite_or_null(value)}});
  OrderedJson json = json_object(kMostMembers);
  json["format"] = kSolutionFormat;
  json["problem"] = problem_json(s);
  json["tool"] = tool_json();
  json["solver"] = s.solver.name;
  json["status"] = to_string(r.status);
  json["message"] = r.message;
  json["cost"] = finite_or_null(r.cost);
  json["cost_by_name"] = std::move(costs);
  if (const double scale = cost_scale(*s.built.problem); scale != 1) json["cost_scale"] = scale;
  if (const auto list = free_numbers(s.built, r.trajectory); !list.empty())
    json["free_numbers"] = free_numbers_json(list);
  json["iterations"] = r.iterations;
  json["residuals"] = residuals_json(r.residuals);
  json["time_s"] = {{"total", r.times.total},
                    {"evaluate", r.times.evaluate},
                    {"differentiate", r.times.differentiate},
                    {"sweep", r.times.sweep},
                    {"rollout", r.times.rollout}};
  json["initial_guess_used"] = guess_json(s);
  json["diagnosis"] = diagnosis_json(answer.diagnosis);
  json["findings"] = findings_json(answer.findings);
  json["constraints"] = violations_json(answer.violations);
  json["soft_constraints"] = violations_json(answer.soft_violations);
  json["dropped_constraints"] = std::move(dropped);
  if (!r.homotopy.empty()) json["homotopy"] = homotopy_json(r.homotopy);
  if (r.attempts.size() > 1) json["attempts"] = attempts_json(r.attempts);
  if (r.restarts) json["restarts"] = restarts_json(*r.restarts);
  if (!s.mesh.empty()) json["mesh"] = mesh_json(s);
  return json;
}

}  // namespace

int count_nulls(const OrderedJson& value) {
  if (!value.is_structured()) return value.is_null() ? 1 : 0;
  int count = 0;
  for (const OrderedJson& part : value) count += count_nulls(part);
  return count;
}

OrderedJson tool_json() {
  const BuildInfo& info = build_info();
  OrderedJson libraries = OrderedJson::object();
  for (const LibraryVersion& library : info.libraries)
    libraries[std::string(library.name)] = library.version;
  return {{"name", "conddp"},
          {"version", info.version},
          {"revision", info.revision},
          {"modified", info.dirty},
          {"build",
           {{"compiler", info.compiler},
            {"type", info.build_type},
            {"flags", info.flags},
            {"march", info.march},
            {"instruction_set", info.instruction_set},
            {"lane_width", kLaneWidth}}},
          {"libraries", std::move(libraries)}};
}

OrderedJson solution_head(const Solution& s) {
  OrderedJson json = head(s);
  json["nulls"] = nulls_json(json, s);
  return json;
}

OrderedJson motion_names(const BuiltProblem& built) {
  OrderedJson phases = OrderedJson::array();
  int first = 0;
  for (const Phase& phase : built.problem->phases()) {
    phases.push_back({{"name", phase.name}, {"first_knot", first}, {"knots", phase.knots()}});
    first += phase.knots();
  }
  OrderedJson json = json_object(7);
  json["columns"] = {{"x", columns_json(built.state_columns, &Column::name)},
                     {"u", columns_json(built.control_columns, &Column::name)}};
  json["units"] = {{"t", "s"},
                   {"x", columns_json(built.state_columns, &Column::unit)},
                   {"u", columns_json(built.control_columns, &Column::unit)}};
  json["phases"] = std::move(phases);
  return json;
}

void add_certificate(OrderedJson certificate, OrderedJson& document) {
  document["certificate"] = std::move(certificate);
  if (const int count = count_nulls(document["certificate"]); count > 0)
    document["nulls"].push_back(
        {{"key", "certificate"}, {"count", count}, {"reason", "not finite"}});
}

OrderedJson diagnosis_json(const Diagnosis& diagnosis) {
  OrderedJson json = {{"pattern", to_string(diagnosis.pattern)}, {"message", diagnosis.message}};
  if (diagnosis.knot >= 0) json["knot"] = diagnosis.knot;
  if (!diagnosis.quantity.empty()) json["quantity"] = diagnosis.quantity;
  if (!diagnosis.remedy.empty()) json["remedy"] = diagnosis.remedy;
  return json;
}

OrderedJson solution_json(const Solution& s) {
  OrderedJson json = head(s);
  json["trajectory"] = trajectory_json(s);
  json["gains"] = gains_json(*s.built.problem, s.result);
  json["multipliers"] = multipliers_json(s);
  json["log"] = log_json(s.result.log);
  json["nulls"] = nulls_json(json, s);
  return json;
}

std::optional<OutputFormats> parse_output_formats(std::string_view list) {
  OutputFormats formats{.json = false, .csv = false};
  for (std::size_t start = 0; start <= list.size();) {
    const std::size_t end = std::min(list.find(',', start), list.size());
    const std::string_view word = list.substr(start, end - start);
    bool* const chosen = word == "json"  ? &formats.json
                         : word == "csv" ? &formats.csv
                         : word == "npz" ? &formats.npz
                                         : nullptr;
    if (chosen == nullptr) return std::nullopt;
    *chosen = true;
    start = end + 1;
  }
  return formats;
}

std::vector<std::filesystem::path> write_solution(const Solution& solution,
                                                  const OrderedJson& document,
                                                  const std::filesystem::path& folder,
                                                  const std::string& page,
                                                  const OutputFormats& formats) {
  create_folder(folder);
  AtomicFiles files;
  std::vector<std::filesystem::path> written, former;
  const auto add = [&](bool wanted, const char* name, const auto& content) {
    if (!wanted) return former.push_back(folder / name);
    files.add(written.emplace_back(folder / name), content());
  };
  add(formats.json, "solution.json", [&] { return json_text(document); });
  add(formats.csv, "trajectory.csv", [&] {
    return trajectory_csv(solution.built, solution.result.trajectory, solution.answer.forces);
  });
  add(formats.csv, "iterations.csv", [&] { return iterations_csv(document.at("log")); });
  add(formats.npz, "trajectory.npz", [&] { return solution_npz(solution); });
  add(!page.empty(), "report.html", [&] { return page; });
  files.commit();
  for (const auto& file : former) {
    std::error_code ignored;
    std::filesystem::remove(file, ignored);
  }
  return written;
}
namespace {

template <class Row>
void copy(const OrderedJson& from, Row out) {
  if (!from.is_array() || static_cast<Eigen::Index>(from.size()) != out.size())
    throw MalformedSolution{"it has other states or controls than its problem"};
  for (Eigen::Index i = 0; i < out.size(); ++i)
    out[i] = from[i].is_number() ? from[i].get<double>() : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

Trajectory stored_trajectory(const OrderedJson& document, const ShootingProblem& problem) {
  Trajectory trajectory = problem.create_trajectory();
  const OrderedJson& stored = solution_member(document, "trajectory");
  const OrderedJson &x = solution_list(stored, "x"), &u = solution_list(stored, "u");
  if (static_cast<int>(x.size()) != problem.knots() + 1 ||
      static_cast<int>(u.size()) != problem.knots())
    throw MalformedSolution{"it has another number of knots than its problem"};
  for (int k = 0; k <= problem.knots(); ++k) copy(x[k], trajectory.x(k));
  const ControlColumns columns(problem);
  for (int k = 0; k < problem.knots(); ++k) copy(columns.own_entries(k, u[k]), trajectory.u(k));
  return trajectory;
}

}  // namespace conddp
