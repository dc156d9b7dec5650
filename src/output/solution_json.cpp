#include "output/solution_json.hpp"

#include <cmath>
#include <fstream>
#include <sstream>

#include "conddp_version.hpp"
#include "output/log_columns.hpp"
#include "problem_file/sha256.hpp"
#include "solvers/option_table.hpp"

namespace conddp {
namespace {

OrderedJson number(double value) {
  return std::isfinite(value) ? OrderedJson(value) : OrderedJson(nullptr);
}

template <class Vector>
OrderedJson numbers(const Vector& values) {
  OrderedJson array = OrderedJson::array();
  for (Eigen::Index i = 0; i < values.size(); ++i) array.push_back(number(values[i]));
  return array;
}

std::string contents(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

OrderedJson problem_json(const Solution& s) {
  OrderedJson problem = {
      {"name", s.spec.name.value}, {"file", s.spec.file.string()}, {"sha256", sha256(s.spec.text)}};
  OrderedJson robots = OrderedJson::array();
  for (const RobotSpec& robot : s.spec.robots)
    robots.push_back({{"file", robot.path.string()}, {"sha256", sha256(contents(robot.path))}});
  problem["robots"] = std::move(robots);
  problem["overrides"] = s.overrides;
  problem["knots"] = s.built.problem->knots();
  problem["duration_s"] = s.built.problem->times().back();
  problem["options"] = options_json(s.spec.solver.options);
  return problem;
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
            {"instruction_set", info.instruction_set}}},
          {"libraries", std::move(libraries)}};
}

OrderedJson residuals_json(const Residuals& r) {
  return {{"stationarity", number(r.stationarity)},
          {"gap", number(r.gap)},
          {"constraint", number(r.constraint)},
          {"complementarity", number(r.complementarity)}};
}

OrderedJson guess_json(const Solution& s) {
  OrderedJson guess = {{"states", s.built.guess_used.states},
                       {"controls", s.built.guess_used.controls},
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

OrderedJson trajectory_json(const Solution& s) {
  const ShootingProblem& problem = *s.built.problem;
  const Trajectory& trajectory = s.result.trajectory;
  OrderedJson x = OrderedJson::array(), u = OrderedJson::array();
  for (int k = 0; k <= problem.knots(); ++k) x.push_back(numbers(trajectory.x(k)));
  for (int k = 0; k < problem.knots(); ++k) u.push_back(numbers(trajectory.u(k)));
  OrderedJson phases = OrderedJson::array();
  int first = 0;
  for (const Phase& phase : problem.phases()) {
    phases.push_back({{"name", phase.name}, {"first_knot", first}, {"knots", phase.knots()}});
    first += phase.knots();
  }
  return {{"columns",
           {{"x", columns_json(s.built.state_columns, &Column::name)},
            {"u", columns_json(s.built.control_columns, &Column::name)}}},
          {"units",
           {{"t", "s"},
            {"x", columns_json(s.built.state_columns, &Column::unit)},
            {"u", columns_json(s.built.control_columns, &Column::unit)}}},
          {"phases", std::move(phases)},
          {"t", problem.times()},
          {"x", std::move(x)},
          {"u", std::move(u)}};
}

OrderedJson gains_json(const SolveResult& result) {
  OrderedJson k = OrderedJson::array(), K = OrderedJson::array();
  for (const Eigen::VectorXd& feedforward : result.feedback.k) k.push_back(numbers(feedforward));
  for (const Eigen::MatrixXd& feedback : result.feedback.K) {
    OrderedJson rows = OrderedJson::array();
    for (Eigen::Index i = 0; i < feedback.rows(); ++i) rows.push_back(numbers(feedback.row(i)));
    K.push_back(std::move(rows));
  }
  OrderedJson gains = {{"regularization", nullptr}, {"k", std::move(k)}, {"K", std::move(K)}};
  if (result.feedback_regularization) gains["regularization"] = *result.feedback_regularization;
  return gains;
}

/// Multipliers of a control bound: not negative, zero where the control is off the bound.
OrderedJson bound_multipliers(const Solution& s, bool upper) {
  const ShootingProblem& problem = *s.built.problem;
  OrderedJson rows = OrderedJson::array();
  for (int k = 0; k < problem.knots(); ++k) {
    const KnotModel& model = *problem.knot(k).model;
    OrderedJson row = OrderedJson::array();
    for (int i = 0; i < problem.nu(k); ++i) {
      const double bound = upper ? model.control_upper()[i] : model.control_lower()[i];
      const double gradient = (upper ? -1 : 1) * s.result.control_gradient[k][i];
      const bool at_bound = s.result.trajectory.u(k)[i] == bound;
      row.push_back(number(at_bound ? std::max(0.0, gradient) : 0.0));
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

OrderedJson multipliers_json(const Solution& s) {
  OrderedJson costates = OrderedJson::array();
  for (Eigen::Index k = 0; k < s.result.costates.cols(); ++k)
    costates.push_back(numbers(s.result.costates.col(k)));
  OrderedJson multipliers = {{"costates", std::move(costates)}};
  if (s.built.problem->has_control_bounds() &&
      static_cast<int>(s.result.control_gradient.size()) == s.built.problem->knots()) {
    multipliers["control_lower"] = bound_multipliers(s, false);
    multipliers["control_upper"] = bound_multipliers(s, true);
  }
  return multipliers;
}

OrderedJson log_json(const std::vector<IterationRecord>& log) {
  OrderedJson rows = OrderedJson::array();
  for (const IterationRecord& record : log) {
    OrderedJson row = OrderedJson::object();
    for (const LogColumn& column : log_columns()) {
      std::string name(column.name);
      if (!column.unit.empty()) (name += '_') += column.unit;
      if (column.integer)
        row[name] = static_cast<long long>(column.get(record));
      else
        row[name] = number(column.get(record));
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace

OrderedJson options_json(const SolverOptions& options) {
  OrderedJson json = OrderedJson::object();
  for (const OptionInfo& info : option_table()) {
    OrderedJson value;
    std::visit([&](const auto& v) { value = v; }, info.get(options));
    if (value.is_number_float()) value = number(value.get<double>());
    const std::size_t dot = info.name.find('.');
    if (dot == std::string_view::npos)
      json[std::string(info.name)] = std::move(value);
    else
      json[std::string(info.name.substr(0, dot))][std::string(info.name.substr(dot + 1))] =
          std::move(value);
  }
  return json;
}

OrderedJson solution_head(const Solution& s) {
  const SolveResult& r = s.result;
  OrderedJson costs = OrderedJson::object();
  for (const auto& [name, value] : cost_by_name(*s.built.problem, r.trajectory))
    costs[name] = number(value);
  OrderedJson dropped = OrderedJson::array();
  for (const DroppedConstraint& constraint : s.built.dropped)
    dropped.push_back(
        {{"name", constraint.name},
         {"violation", number(violation(constraint, *s.built.problem, r.trajectory))}});
  return {{"format", kSolutionFormat},
          {"problem", problem_json(s)},
          {"tool", tool_json()},
          {"solver", s.solver.name},
          {"status", to_string(r.status)},
          {"message", r.message},
          {"cost", number(r.cost)},
          {"cost_by_name", std::move(costs)},
          {"iterations", r.iterations},
          {"residuals", residuals_json(r.residuals)},
          {"time_s",
           {{"total", r.times.total},
            {"evaluate", r.times.evaluate},
            {"differentiate", r.times.differentiate},
            {"sweep", r.times.sweep},
            {"rollout", r.times.rollout}}},
          {"initial_guess_used", guess_json(s)},
          {"dropped_constraints", std::move(dropped)}};
}

OrderedJson solution_json(const Solution& s) {
  OrderedJson json = solution_head(s);
  json["trajectory"] = trajectory_json(s);
  json["gains"] = gains_json(s.result);
  json["multipliers"] = multipliers_json(s);
  json["log"] = log_json(s.result.log);
  return json;
}

}  // namespace conddp
