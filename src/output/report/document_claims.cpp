#include "output/report/document_claims.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "analysis/certificate/certificate_doubt.hpp"
#include "base/json/json_document.hpp"
#include "ocp/problem/cost_scale.hpp"
#include "output/solution/finding_report.hpp"
#include "output/solution/solution.hpp"
#include "output/solution/solution_json.hpp"
#include "problem_file/expand/expand_problem.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {

AnswerClaims answer_claims(const Solution& s) {
  const ShootingProblem& problem = *s.built.problem;
  AnswerClaims claims{
      .solution = claims_of(problem, s.result, s.answer.values, s.built.facts().solver.options),
      .iterations = s.result.iterations,
      .duration = problem.times(s.result.trajectory).back(),
      .free_numbers = free_numbers(s.built, s.result.trajectory),
      .constraint_values = s.result.constraint_values,
      .violations = s.answer.violations,
      .soft_violations = s.answer.soft_violations,
      .dropped = s.answer.dropped,
      .forces = s.answer.forces,
      .log = s.result.log};
  claims.solution.tangent_names = tangent_columns(s.built);
  for (auto* list : {&claims.violations, &claims.soft_violations})
    for (ConstraintViolation& v : *list) v.value = finite_or_open(v.value);
  for (auto& [name, value] : claims.dropped) value = finite_or_open(value);
  for (double& value : claims.constraint_values) value = finite_or_open(value);
  for (IterationRecord& row : claims.log)
    for (double* figure : {&row.cost, &row.gap, &row.constraint, &row.stationarity})
      *figure = finite_or_open(*figure);
  if (!s.mesh.empty())
    claims.grid_error = {finite_or_open(s.mesh.back().error), s.built.facts().mesh->error};
  return claims;
}
namespace {

using Json = OrderedJson;

const Json& at(const Json& document, std::initializer_list<const char*> path) {
  const Json* value = &document;
  for (const char* key : path) value = &solution_member(*value, key);
  return *value;
}

/// A number, or NaN for null.
double number(const Json& value, const std::string& what) {
  if (value.is_null()) return Check::kNone;
  if (!value.is_number()) throw MalformedSolution{fmt::format("'{}' is not a number", what)};
  return value.get<double>();
}

/// Compares statements of a document with those expected.
class Statements {
 public:
  explicit Statements(std::vector<Check>& checks) : checks_(checks) {}

  void fail(std::string name, std::string message) {
    checks_.push_back({.name = std::move(name), .holds = false, .message = std::move(message)});
  }
  /// Compares by keys: parsed documents have them in another order.
  void expect(std::string name, const Json& claimed, const Json& actual) {
    const Json patch = Json::diff(actual, claimed);
    if (patch.empty())
      checks_.push_back({std::move(name)});
    else
      fail(std::move(name),
           claimed.is_structured() && actual.is_structured()
               ? difference(patch, claimed, actual)
               : fmt::format("{} in the answer, {} in the problem", claimed.dump(), actual.dump()));
  }

 private:
  static std::string difference(const Json& patch, const Json& claimed, const Json& actual) {
    const Json::json_pointer place(patch.at(0).at("path").get<std::string>());
    const auto value = [&](const Json& json) {
      return json.contains(place) ? json.at(place).dump() : std::string("nothing");
    };
    return fmt::format("{}: {} in the answer, {} in the problem{}", place.to_string(),
                       value(claimed), value(actual),
                       patch.size() > 1 ? fmt::format(" ({} more differ)", patch.size() - 1) : "");
  }

  std::vector<Check>& checks_;
};

/// Reads the claims of a document. Lists of other lengths than the problem's become failed checks.
class Reader {
 public:
  Reader(const Json& document, const BuiltProblem& built, std::vector<Check>& checks)
      : document_(document),
        facts_(built.facts()),
        built_(built),
        problem_(*built.problem),
        controls_(problem_),
        checks_(checks),
        statements_(checks),
        claims_{.solution = SolutionClaims(problem_)} {}

  std::optional<AnswerClaims> read() {
    compare_with_problem();
    read_motion();
    read_multipliers();
    read_gains();
    if (!fits_) return std::nullopt;
    checks_.push_back({"shapes"});
    read_figures();
    read_violations("constraints", claims_.violations);
    read_violations("soft_constraints", claims_.soft_violations);
    for (const Json& entry : solution_list(document_, "dropped_constraints"))
      claims_.dropped.emplace_back(solution_text(entry, "name"), member(entry, "violation"));
    read_forces();
    read_log();
    return std::move(claims_);
  }

 private:
  static double member(const Json& object, const char* key) {
    return number(at(object, {key}), key);
  }
  /// A whole number, or −2 for anything else.
  static int count(const Json& object, const char* key) {
    const Json& value = at(object, {key});
    return value.is_number_integer() ? value.get<int>() : -2;
  }

  /// The solver of the file; with `auto`, the claimed solver if it is a candidate.
  std::string solver_name() const {
    if (facts_.solver.name.value == kAutoSolver)
      for (const SolverInfo* info : auto_solvers(problem_, facts_.solver.options))
        if (at(document_, {"solver"}) == info->name) return std::string(info->name);
    return facts_.solver.name.value;
  }
  void compare_with_problem() {
    const Json &problem = at(document_, {"problem"}), &motion = at(document_, {"trajectory"});
    checks_.push_back(configuration_check(at(problem, {"configuration"}), built_));
    statements_.expect("name", at(problem, {"name"}), facts_.name.value);
    statements_.expect("solver", at(document_, {"solver"}), solver_name());
    statements_.expect("options", at(problem, {"options"}), expand_options(facts_.solver.options));
    statements_.expect("knots", at(problem, {"knots"}), problem_.knots());
    if (document_.contains("cost_scale"))
      statements_.expect("cost scale", document_.at("cost_scale"), cost_scale(problem_));
    const Json expected = motion_names(built_);
    for (const char* kind : {"x", "u"})
      for (const char* part : {"columns", "units"})
        statements_.expect(fmt::format("{} of {}", part, kind), at(motion, {part, kind}),
                           expected[part][kind]);
    statements_.expect("units of t", at(motion, {"units", "t"}), expected["units"]["t"]);
    statements_.expect("phases", at(motion, {"phases"}), expected["phases"]);
  }

  /// True if a list has this length. Names of its places are only made for messages.
  bool has_size(const std::string& what, int row, const Json& list, int expected) {
    const auto name = [&] { return row < 0 ? what : fmt::format("{}[{}]", what, row); };
    if (!list.is_array()) throw MalformedSolution{fmt::format("'{}' is not a list", name())};
    if (static_cast<int>(list.size()) == expected) return true;
    fits_ = false;
    statements_.fail(
        name(), fmt::format("{} entries in the answer, {} in the problem", list.size(), expected));
    return false;
  }
  Eigen::VectorXd numbers(const std::string& what, int row, const Json& list, int count) {
    Eigen::VectorXd values = Eigen::VectorXd::Zero(count);
    if (has_size(what, row, list, count))
      for (int i = 0; i < count; ++i) values[i] = number(list[i], what);
    return values;
  }
  /// Reads one row per node or knot; `length` is that of a row, `take` gets the rows.
  template <class Length, class Take>
  void rows(const std::string& what, const Json& list, int count, Length length, Take take) {
    has_size(what, -1, list, count);
    for (int k = 0; k < std::min(count, static_cast<int>(list.size())); ++k)
      take(k, numbers(what, k, list[k], length(k)));
  }
  /// Number of controls that the file contains for a knot.
  int table_controls(int k) const {
    return controls_.are_some(k) ? controls_.count() : problem_.nu(k);
  }
  /// Reads the controls of all knots, each with its own ones.
  template <class Take>
  void control_rows(const std::string& what, const Json& list, Take take) {
    rows(
        what, list, problem_.knots(), [&](int k) { return table_controls(k); },
        [&](int k, const Eigen::VectorXd& row) { take(k) = controls_.own(k, row); });
  }

  void read_motion() {
    SolutionClaims& c = claims_.solution;
    const int N = problem_.knots();
    const Json& motion = document_["trajectory"];
    const Eigen::VectorXd t = numbers("trajectory.t", -1, at(motion, {"t"}), N + 1);
    c.times.assign(t.begin(), t.end());
    rows(
        "trajectory.x", at(motion, {"x"}), N + 1, [&](int) { return problem_.nx(); },
        [&](int k, const Eigen::VectorXd& x) { c.trajectory.x(k) = x; });
    control_rows("trajectory.u", at(motion, {"u"}), [&](int k) { return c.trajectory.u(k); });
  }

  void read_multipliers() {
    SolutionClaims& c = claims_.solution;
    const Json& multipliers = at(document_, {"multipliers"});
    const auto read_states = [&](const char* key, Eigen::MatrixXd& to) {
      rows(
          fmt::format("multipliers.{}", key), at(multipliers, {key}), problem_.knots() + 1,
          [&](int) { return problem_.ndx(); },
          [&](int k, const Eigen::VectorXd& row) { to.col(k) = row; });
    };
    read_states("costates", c.costates);
    read_states("state_gradient", c.state_gradient);
    for (auto [key, to] : {std::pair("control_lower", &c.lower_multipliers),
                           std::pair("control_upper", &c.upper_multipliers)})
      if (multipliers.contains(key))
        control_rows(
            fmt::format("multipliers.{}", key),
            multipliers.at(key), [&](int k) -> auto& { return (*to)[k]; });
    read_constraints(multipliers);
  }

  /// The constraints of all nodes must be present, in order and with the correct number of rows.
  void read_constraints(const Json& multipliers) {
    const auto& constraints = problem_.constraints();
    claims_.constraint_values.setZero(problem_.constraint_rows());
    if (constraints.empty()) return;
    const std::string all = "multipliers.constraints";
    const Json& list = at(multipliers, {"constraints"});
    if (!has_size(all, -1, list, static_cast<int>(constraints.size()))) return;
    for (std::size_t i = 0; i < constraints.size(); ++i) {
      const NodeConstraint& c = constraints[i];
      if (solution_text(list[i], "name") != c.term->name || at(list[i], {"node"}) != c.node)
        throw MalformedSolution{fmt::format("'{}[{}]' is not the constraint '{}' of node {}", all,
                                            i, c.term->name, c.node)};
      const auto read = [&](const char* key, Eigen::VectorXd& to) {
        to.segment(c.row, c.term->rows) =
            numbers(all, static_cast<int>(i), at(list[i], {key}), c.term->rows);
      };
      read("multiplier", claims_.solution.multipliers);
      read("value", claims_.constraint_values);
    }
  }

  void read_gains() {
    SolutionClaims& c = claims_.solution;
    const Json& gains = at(document_, {"gains"});
    const Json& K = at(gains, {"K"});
    if (has_size("gains.K", -1, K, problem_.knots()))
      for (int k = 0; k < problem_.knots(); ++k) {
        Eigen::MatrixXd table(table_controls(k), problem_.ndx());
        rows(
            fmt::format("gains.K[{}]", k), K[k], table_controls(k),
            [&](int) { return problem_.ndx(); },
            [&](int i, const Eigen::VectorXd& row) { table.row(i) = row; });
        c.gains[k] = table;
        if (controls_.are_some(k)) c.gains[k] = table(controls_.columns_of(k), Eigen::all);
      }
    control_rows(
        "gains.k", at(gains, {"k"}), [&](int k) -> auto& { return c.feedforward[k]; });
    c.gain_regularization = number(at(gains, {"regularization"}), "gains");
  }

  void read_figures() {
    SolutionClaims& c = claims_.solution;
    c.status = solution_text(document_, "status");
    c.converged = c.status == to_string(SolveStatus::converged);
    c.cost = member(document_, "cost");
    const Json& costs = at(document_, {"cost_by_name"});
    if (!costs.is_object()) throw MalformedSolution{"'cost_by_name' is not an object"};
    for (const auto& [name, value] : costs.items())
      c.cost_by_name.emplace_back(name, number(value, "cost_by_name"));
    const Json& residuals = at(document_, {"residuals"});
    c.stationarity = member(residuals, "stationarity");
    c.gap = member(residuals, "gap");
    c.constraint = member(residuals, "constraint");
    c.complementarity = member(residuals, "complementarity");
    c.tolerances = facts_.solver.options.tolerances;
    c.tangent_names = tangent_columns(built_);
    claims_.iterations = count(document_, "iterations");
    claims_.duration = number(at(document_, {"problem", "duration_s"}), "duration_s");
    if (document_.contains("free_numbers"))
      for (const Json& entry : solution_list(document_, "free_numbers"))
        claims_.free_numbers.push_back({solution_text(entry, "name"), member(entry, "value"),
                                        solution_text(entry, "unit"),
                                        solution_text(entry, "limit")});
    if (document_.contains("mesh")) {
      const Json& asked = at(document_, {"mesh", "asked"});
      claims_.grid_error = {number(at(document_, {"mesh", "error"}), "mesh.error"),
                            asked.is_number() ? asked.get<double>() : Check::kNone};
    }
  }

  /// Answers of former versions may lack a list.
  void read_violations(const char* key, std::vector<ConstraintViolation>& to) {
    if (!document_.contains(key)) return;
    for (const Json& entry : solution_list(document_, key))
      to.push_back(
          {solution_text(entry, "name"), member(entry, "violation"), count(entry, "node")});
  }

  void read_forces() {
    claims_.forces = no_contact_forces(built_, problem_.knots());
    const Json& all = at(document_, {"trajectory", "contact_forces"});
    if (!all.is_object() || all.size() != claims_.forces.contacts.size())
      statements_.fail("contact_forces",
                       fmt::format("of {} contacts in the answer, {} in the problem", all.size(),
                                   claims_.forces.contacts.size()));
    for (auto& contact : claims_.forces.contacts) {
      const Json& list = at(all, {contact.name.c_str()});
      const std::string what = "forces of " + contact.name;
      if (!has_size(what, -1, list, problem_.knots())) continue;
      for (int k = 0; k < problem_.knots(); ++k) {
        if (list[k].is_null()) continue;
        const Eigen::VectorXd force = numbers(what, k, list[k], contact.torque ? 6 : 3);
        std::copy(force.begin(), force.end(), contact.wrench[k].emplace().begin());
      }
    }
  }

  void read_log() {
    for (const Json& row : solution_list(document_, "log"))
      claims_.log.push_back({.iteration = count(row, "iteration"),
                             .cost = member(row, "cost"),
                             .stationarity = member(row, "stationarity"),
                             .gap = member(row, "gap"),
                             .constraint = member(row, "constraint")});
  }

  const Json& document_;
  const ProblemFacts& facts_;
  const BuiltProblem& built_;
  const ShootingProblem& problem_;
  const ControlColumns controls_;
  std::vector<Check>& checks_;
  Statements statements_;
  AnswerClaims claims_;
  bool fits_ = true;
};

bool is_same_figure(const Json& claimed, const Json& actual) {
  constexpr double kTolerance = 1e-10;
  if (claimed == actual) return true;
  const double here = actual.is_number_float() ? actual.get<double>() : Check::kNone;
  if (claimed.is_null()) return actual.is_number() && !std::isfinite(here);
  return claimed.is_number() && std::isfinite(here) &&
         std::abs(claimed.get<double>() - here) <= kTolerance * std::max(1.0, std::abs(here));
}

/// The first differing figure of a finding, in words.
std::string first_difference(const Json& claims, const Json& expected, const Finding& found) {
  for (const auto& [key, value] : expected.items()) {
    const Json& claimed = at(claims, {key.c_str()});
    if (key == "message" || key == "remedy" || is_same_figure(claimed, value)) continue;
    return fmt::format("'{}' of {} of {}: {} in the answer, {} in its motion", key,
                       to_string(found.kind), found.subject, claimed.dump(), value.dump());
  }
  return {};
}

/// Compares the certificate in an answer with the one found. Checks of the certificate itself come
/// last.
class FormerCertificate {
 public:
  FormerCertificate(const Json& former, Certificate& found)
      : former_(former), found_(found), statements_(found.checks) {}

  void compare() {
    statements_.expect("certificate", at(former_, {"holds"}), found_.holds());
    if (former_.contains("verdict")) verdict(solution_text(former_, "verdict"));
    if (former_.contains("optimality")) optimality(former_.at("optimality"));
    if (former_.contains("second_order")) second_order(former_.at("second_order"));
    const Json& list = solution_list(former_, "checks");
    for (std::size_t i = 0; i < list.size(); ++i) {
      const std::string name = solution_text(list[i], "name");
      if (i >= found_.checks.size() || found_.checks[i].name != name)
        return statements_.fail("certificate of " + name, "is another check here");
      if (!says_the_same(list[i], found_.checks[i]))
        return statements_.fail("certificate of " + name, "differs from the result found here");
    }
  }

 private:
  static bool says_the_same(const Json& former, const Check& check) {
    const auto agrees = [&](const char* key, double mine, double allowed) {
      const double told = former.contains(key) ? number(former.at(key), key) : Check::kNone;
      return (std::isnan(told) && !std::isfinite(mine)) || std::abs(told - mine) <= allowed;
    };
    const double rounding = 1e-12 * std::abs(check.claimed);
    const double slack = std::isnan(check.tolerance) ? 0 : 2 * check.tolerance;
    return at(former, {"holds"}) == check.holds && agrees("claimed", check.claimed, rounding) &&
           agrees("found", check.found, slack);
  }

  /// Rounding may turn positive curvature into zero; other differences are errors.
  void verdict(const std::string& told) {
    const auto coarse = [](std::string_view word) {
      return word == to_string(Verdict::stationary) ? to_string(Verdict::local_minimum) : word;
    };
    const std::string_view mine = to_string(found_.verdict());
    if (coarse(told) != coarse(mine))
      statements_.fail("certificate of verdict",
                       fmt::format("'{}' in the answer, '{}' here", told, mine));
  }

  /// A former figure must be reproduced to a thousandth and to this rounding.
  void figure(const char* name, const Json& former, const char* key, double mine, double rounding) {
    const double told = number(at(former, {key}), key);
    if ((std::isnan(told) && !std::isfinite(mine)) ||
        std::abs(told - mine) <= 1e-3 * std::abs(mine) + rounding)
      return;
    found_.checks.push_back(
        {name, false, told, mine, Check::kNone, "",
         fmt::format("'{}' is {:.3g} in the answer, {:.3g} here", key, told, mine)});
  }

  /// Second-order figures are in the unit of the cost.
  void second_order(const Json& former) {
    constexpr const char* kName = "certificate of second order";
    if (!found_.second_order) return statements_.fail(kName, "the answer did not converge");
    const SecondOrder& o = *found_.second_order;
    for (const auto& [key, mine] : kSecondOrderFigures)
      figure(kName, former, key, o.*mine, 1e-3 * o.cost_size);
  }

  void optimality(const Json& former) {
    constexpr double kNewtonRounding = 1e-12;
    const Optimality& o = found_.optimality;
    for (const auto& [key, mine, rounding] : kOptimalityFigures)
      figure("certificate of optimality", former, key, o.*mine,
             10 * (rounding != nullptr ? o.*rounding : kNewtonRounding));
  }

  const Json& former_;
  Certificate& found_;
  Statements statements_;
};

}  // namespace

std::vector<std::string> statement_names(const ShootingProblem& problem) {
  std::vector<std::string> names = {"configuration", "name", "solver", "options", "knots"};
  if (cost_scale(problem) != 1) names.emplace_back("cost scale");
  names.insert(names.end(), {"columns of x", "units of x", "columns of u", "units of u",
                             "units of t", "phases", "shapes"});
  return names;
}

std::optional<AnswerClaims> read_claims(const OrderedJson& document, const BuiltProblem& built,
                                        std::vector<Check>& checks) {
  return Reader(document, built, checks).read();
}

Check findings_check(const OrderedJson& list, const std::vector<Finding>& found) {
  const Json expected = findings_json(found);
  Check check{"findings"};
  if (list.size() != expected.size())
    check.message = fmt::format("{} in the answer, {} in its motion", list.size(), expected.size());
  for (std::size_t i = 0; check.message.empty() && i < expected.size(); ++i)
    check.message = first_difference(list[i], expected[i], found[i]);
  check.holds = check.message.empty();
  return check;
}

void check_nulls_and_certificate(const OrderedJson& document, Certificate& certificate) {
  if (document.contains("nulls"))
    for (const Json& entry : solution_list(document, "nulls")) {
      const std::string key = solution_text(entry, "key");
      std::string pointer = "/" + key;
      std::replace(pointer.begin(), pointer.end(), '.', '/');
      const Json::json_pointer place(pointer);
      Statements(certificate.checks)
          .expect("nulls of " + key, at(entry, {"count"}),
                  document.contains(place) ? count_nulls(document.at(place)) : 0);
    }
  if (document.contains("certificate"))
    FormerCertificate(document.at("certificate"), certificate).compare();
}

Check configuration_check(const OrderedJson& claimed, const BuiltProblem& built) {
  OrderedJson actual = expand_problem(built);
  if (claimed == actual) return {"configuration", true};
  OrderedJson answer = claimed;
  for (OrderedJson* json : {&answer, &actual}) {
    if (json->is_object()) json->erase("initial_guess");
    // Numbers are rounded as in the file, because its text is compared.
    *json = OrderedJson::parse(json->dump());
  }
  const OrderedJson patch = OrderedJson::diff(actual, answer);
  Check check{"configuration", patch.empty()};
  if (!patch.empty())
    check.message = "differs from the problem at " + patch[0]["path"].get<std::string>();
  if (patch.size() > 1) check.message += fmt::format(" and {} more places", patch.size() - 1);
  return check;
}

}  // namespace conddp
