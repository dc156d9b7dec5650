#include "output/report/solution_certificate.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <tuple>

#include <fmt/format.h>

#include "analysis/certificate/place_text.hpp"
#include "analysis/derivatives/derivative_check.hpp"
#include "base/json/number_block.hpp"
#include "base/json/solution_members.hpp"
#include "ocp/problem/by_name.hpp"
#include "ocp/problem/control_columns.hpp"
#include "ocp/problem/cost_scale.hpp"
#include "output/report/configuration_check.hpp"
#include "output/solution/contact_forces.hpp"
#include "output/solution/finding_report.hpp"
#include "output/solution/solution_json.hpp"
#include "problem_file/expand/expand_problem.hpp"
#include "solvers/common/option_table.hpp"

namespace conddp {
namespace {

using Json = OrderedJson;

const Json& at(const Json& document, std::initializer_list<const char*> path) {
  const Json* value = &document;
  for (const char* key : path) value = &solution_member(*value, key);
  return *value;
}

/// A number, or NaN for null.
double number(const Json& value, const char* what) {
  if (value.is_null()) return Check::kNone;
  if (!value.is_number()) throw MalformedSolution{fmt::format("'{}' is not a number", what)};
  return value.get<double>();
}

Eigen::VectorXd vector(const Json& list, const char* what) {
  if (const auto block = NumberBlock::of(list); block && !block->is_table()) {
    Eigen::VectorXd v(block->size());
    block->copy(v.data());
    return v;
  }
  Eigen::VectorXd v(list.size());
  for (std::size_t i = 0; i < list.size(); ++i) v[i] = number(list[i], what);
  return v;
}

/// Rows of numbers: a block, or a list of lists and of blocks.
class NumberTable {
 public:
  /// `list` is a list or a block and must outlive this object.
  NumberTable(const Json& list, const char* what) : list_(list), what_(what) {
    if (const auto block = NumberBlock::of(list); block && block->is_table()) block_ = block;
  }

  void copy_row(int row, Eigen::Ref<Eigen::VectorXd> out) const {
    if (block_)
      block_->copy_row(static_cast<std::size_t>(row), out.data());
    else
      out = vector(list_[row], what_);
  }
  Eigen::VectorXd row(int row) const {
    if (!block_) return vector(list_[row], what_);
    Eigen::VectorXd numbers(block_->columns());
    copy_row(row, numbers);
    return numbers;
  }

 private:
  const Json& list_;
  const char* what_;
  std::optional<NumberBlock> block_;
};

/// Collects mismatches, and the claims of a document whose shapes match.
class Reader {
 public:
  Reader(const Json& document, const ProblemSpec& spec, const BuiltProblem& built,
         const Answer* written)
      : document_(document),
        spec_(spec),
        built_(built),
        problem_(*built.problem),
        controls_(problem_),
        written_(written) {}

  SolutionCertificate judge(bool with_replay) {
    const auto began = std::chrono::steady_clock::now();
    SolutionCertificate result;
    compare();
    result.tangent_names = tangent_columns(built_);
    if (with_replay && claims_)
      result.replay = replay(problem_, claims_->trajectory, claims_->gains);
    result.contacts = judge_contacts(with_replay);
    if (claims_)
      result.findings =
          own_values_ ? findings_of(spec_, built_, claims_->trajectory, claims_->gains, *values_)
                      : written_->findings;
    findings(result.findings);
    nulls();
    former_certificate();
    result.converged = claims_ && claims_->converged;
    result.grid_warning = std::move(grid_warning_);
    result.checks = std::move(certificate_);
    result.time_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    return result;
  }

 private:
  /// The solver of the file; with `auto`, the claimed solver if it is a candidate.
  std::string solver_name() const {
    if (spec_.solver.name.value == kAutoSolver)
      for (const SolverInfo* info : auto_solvers(problem_, spec_.solver.options))
        if (at(document_, {"solver"}) == info->name) return std::string(info->name);
    return spec_.solver.name.value;
  }
  /// Options with former names replaced by current ones.
  static Json with_present_names(const Json& options) {
    if (!options.is_object()) return options;
    Json renamed = Json::object();
    for (const auto& [key, value] : options.items()) {
      std::string_view name = key;
      for (const OptionInfo& info : option_table())
        if (info.formerly == name) name = info.name;
      renamed[std::string(name)] = value;
    }
    return renamed;
  }

  void compare() {
    const Json& configuration = at(document_, {"problem", "configuration"});
    add(written_ ? Check{"configuration", true}
                 : configuration_check(configuration, spec_, built_));
    statement("name", at(document_, {"problem", "name"}), spec_.name.value);
    statement("solver", at(document_, {"solver"}), solver_name());
    statement("options", with_present_names(at(document_, {"problem", "options"})),
              expand_options(spec_.solver.options));
    statement("knots", at(document_, {"problem", "knots"}), problem_.knots());
    if (document_.contains("cost_scale"))
      statement("cost scale", document_.at("cost_scale"), cost_scale(problem_));
    columns("x", built_.state_columns);
    columns("u", built_.control_columns);
    statement("units of t", at(document_, {"trajectory", "units", "t"}), "s");
    phases();
    sizes();
    if (!fits_) return;
    claims_.emplace(problem_);
    read_claims();
    const bool is_answer = written_ != nullptr && written_->values.are_at(claims_->trajectory);
    values_ = is_answer ? &written_->values : &own_values_.emplace(problem_, claims_->trajectory);
    std::optional<Certificate> known;
    if (written_ && written_->certified) known = written_->certified->of(*claims_);
    const Certificate numbers = known ? *std::move(known) : certify(problem_, *claims_, *values_);
    certificate_.optimality = numbers.optimality;
    certificate_.checks.insert(certificate_.checks.end(), numbers.checks.begin(),
                               numbers.checks.end());
    certificate_.second_order = numbers.second_order;
    certificate_.curvature = numbers.curvature;
    certificate_.optimality_in_doubt = numbers.optimality_in_doubt;
    evaluate_constraints();
    if (spec_.runs_code()) derivatives_of_code();
    if (document_.contains("mesh")) error_of_grid();
    dropped();
    forces();
    log();
    status();
  }

  /// Checks contact-implicit problems; only converged answers make claims about contacts.
  std::optional<ContactCertificate> judge_contacts(bool with_replay) {
    if (!claims_) return std::nullopt;
    const auto motion = contact_motion(problem_, claims_->trajectory);
    if (!motion) return std::nullopt;
    ContactCertificate result = certify_contacts(*motion);
    if (claims_->converged)
      for (Check& check : contact_checks(
               *motion, result.measures, claims_->tolerances,
               [&](int k, const std::string&what) { return place_text(problem_, k, what); }))
        add(std::move(check));
    if (with_replay) result.replay = replay_contacts(*motion, claims_->gains);
    return result;
  }

  void add(Check check) { certificate_.checks.push_back(std::move(check)); }
  void fail(std::string name, std::string message) {
    add({std::move(name), false, Check::kNone, Check::kNone, Check::kNone, "", std::move(message)});
  }

  /// Checks that a text or integer equals that of the problem.
  bool statement(std::string name, const Json& claimed, const Json& actual) {
    // Compares by keys: parsed documents have them in another order.
    const bool holds = Json::diff(actual, claimed).empty();
    std::string message;
    if (!holds)
      message =
          claimed.is_structured() && actual.is_structured()
              ? difference(claimed, actual)
              : fmt::format("{} in the answer, {} in the problem", claimed.dump(), actual.dump());
    add({std::move(name), holds, Check::kNone, Check::kNone, Check::kNone, "", std::move(message)});
    return holds;
  }

  static std::string difference(const Json& claimed, const Json& actual) {
    const Json patch = Json::diff(actual, claimed);
    const Json::json_pointer place(patch.at(0).at("path").get<std::string>());
    const auto value = [&](const Json& json) {
      return json.contains(place) ? json.at(place).dump() : std::string("nothing");
    };
    return fmt::format("{}: {} in the answer, {} in the problem{}", place.to_string(),
                       value(claimed), value(actual),
                       patch.size() > 1 ? fmt::format(" ({} more differ)", patch.size() - 1) : "");
  }

  void columns(const char* kind, const std::vector<Column>& actual) {
    Json names = Json::array(), units = Json::array();
    for (const Column& column : actual) {
      names.push_back(column.name);
      units.push_back(column.unit);
    }
    statement(fmt::format("columns of {}", kind), at(document_, {"trajectory", "columns", kind}),
              names);
    statement(fmt::format("units of {}", kind), at(document_, {"trajectory", "units", kind}),
              units);
  }

  void phases() {
    Json actual = Json::array();
    int first = 0;
    for (const Phase& phase : problem_.phases()) {
      actual.push_back({{"name", phase.name}, {"first_knot", first}, {"knots", phase.knots()}});
      first += phase.knots();
    }
    statement("phases", at(document_, {"trajectory", "phases"}), actual);
  }

  /// Names of rows are only created for messages.
  template <class Name>
  void expect(const Name& name, std::optional<std::size_t> found, int expected) {
    if (!found) throw MalformedSolution{fmt::format("'{}' is not a list", name())};
    if (static_cast<int>(*found) == expected) return;
    fits_ = false;
    fail(name(), fmt::format("{} entries in the answer, {} in the problem", *found, expected));
  }
  void size(const std::string& name, const Json& list, int expected) {
    expect([&] { return name; }, entries_of(list), expected);
  }

  /// Checks for one row of numbers per node or knot; `columns` returns the length of a knot's row.
  template <class Columns>
  void rows(const std::string& name, const Json& list, int count, Columns columns) {
    size(name, list, count);
    const auto block = NumberBlock::of(list);
    const bool is_table = block && block->is_table();
    for (int k = 0; k < std::min(count, static_cast<int>(*entries_of(list))); ++k)
      expect([&] { return fmt::format("{}[{}]", name, k); },
             is_table ? block->columns() : entries_of(list[k]), columns(k));
  }

  /// Number of controls that the file contains for a knot.
  int table_controls(int k) const {
    return controls_.are_some(k) ? controls_.count() : problem_.nu(k);
  }

  void sizes() {
    const int N = problem_.knots();
    const auto nx = [&](int) { return problem_.nx(); };
    const auto ndx = [&](int) { return problem_.ndx(); };
    const auto nu = [&](int k) { return table_controls(k); };
    size("trajectory.t", at(document_, {"trajectory", "t"}), N + 1);
    rows("trajectory.x", at(document_, {"trajectory", "x"}), N + 1, nx);
    rows("trajectory.u", at(document_, {"trajectory", "u"}), N, nu);
    const Json& multipliers = at(document_, {"multipliers"});
    rows("multipliers.costates", at(multipliers, {"costates"}), N + 1, ndx);
    rows("multipliers.state_gradient", at(multipliers, {"state_gradient"}), N + 1, ndx);
    for (const char* kind : {"control_lower", "control_upper"})
      if (multipliers.contains(kind))
        rows(fmt::format("multipliers.{}", kind), multipliers.at(kind), N, nu);
    check_constraint_list(multipliers);
    const Json& K = at(document_, {"gains", "K"});
    rows("gains.K", K, N, nu);
    for (int k = 0; fits_ && k < N; ++k) rows(fmt::format("gains.K[{}]", k), K[k], nu(k), ndx);
    rows("gains.k", at(document_, {"gains", "k"}), N, nu);
    if (fits_) add({"shapes", true, Check::kNone, Check::kNone, Check::kNone, "", ""});
  }

  /// Checks that the constraints of all nodes are present, in order and with the correct number of
  /// rows.
  void check_constraint_list(const Json& multipliers) {
    const auto& constraints = problem_.constraints();
    if (constraints.empty()) return;
    const Json& list = at(multipliers, {"constraints"});
    size("multipliers.constraints", list, static_cast<int>(constraints.size()));
    for (std::size_t i = 0; fits_ && i < constraints.size(); ++i) {
      const std::string what = fmt::format("multipliers.constraints[{}]", i);
      if (solution_text(list[i], "name") != constraints[i].term->name ||
          at(list[i], {"node"}) != constraints[i].node)
        throw MalformedSolution{fmt::format("'{}' is not the constraint '{}' of node {}", what,
                                            constraints[i].term->name, constraints[i].node)};
      size(what, at(list[i], {"multiplier"}), constraints[i].term->rows);
    }
  }

  void read_claims() {
    read_motion();
    read_figures();
    read_multipliers();
    read_gains();
    claims_->tolerances = spec_.solver.options.tolerances;
    claims_->tangent_names = tangent_columns(built_);
  }
  void read_motion() {
    SolutionClaims& c = *claims_;
    const int N = problem_.knots();
    const Json& trajectory = at(document_, {"trajectory"});
    const Json& times = trajectory["t"];
    const NumberTable x(trajectory["x"], "trajectory.x"), u(trajectory["u"], "trajectory.u");
    for (int k = 0; k <= N; ++k) {
      c.times.push_back(number(times[k], "trajectory.t"));
      x.copy_row(k, c.trajectory.x(k));
      if (k < N) copy_controls(u, k, c.trajectory.u(k));
    }
  }
  /// Copies a knot's own controls from the row of a table.
  void copy_controls(const NumberTable& table, int k, Eigen::Ref<Eigen::VectorXd> out) const {
    if (controls_.are_some(k))
      out = controls_.own(k, table.row(k));
    else
      table.copy_row(k, out);
  }
  void read_figures() {
    SolutionClaims& c = *claims_;
    c.status = solution_text(document_, "status");
    c.converged = c.status == to_string(SolveStatus::converged);
    c.cost = number(at(document_, {"cost"}), "cost");
    const Json& costs = at(document_, {"cost_by_name"});
    if (!costs.is_object()) throw MalformedSolution{"'cost_by_name' is not an object"};
    for (const auto& [name, value] : costs.items())
      c.cost_by_name.emplace_back(name, number(value, "cost_by_name"));
    const Json& residuals = at(document_, {"residuals"});
    c.stationarity = number(at(residuals, {"stationarity"}), "residuals.stationarity");
    c.gap = number(at(residuals, {"gap"}), "residuals.gap");
    c.constraint = number(at(residuals, {"constraint"}), "residuals.constraint");
    c.complementarity = number(at(residuals, {"complementarity"}), "residuals.complementarity");
  }
  void read_multipliers() {
    SolutionClaims& c = *claims_;
    const Json& multipliers = document_["multipliers"];
    const NumberTable costates(multipliers["costates"], "multipliers.costates"),
        state_gradient(multipliers["state_gradient"], "multipliers.state_gradient");
    for (int k = 0; k <= problem_.knots(); ++k) {
      costates.copy_row(k, c.costates.col(k));
      state_gradient.copy_row(k, c.state_gradient.col(k));
    }
    const auto read_controls = [&](const char* key, std::vector<Eigen::VectorXd>& list) {
      if (!multipliers.contains(key)) return;
      const NumberTable table(multipliers.at(key), key);
      for (int k = 0; k < problem_.knots(); ++k) copy_controls(table, k, list[k]);
    };
    read_controls("control_lower", c.lower_multipliers);
    read_controls("control_upper", c.upper_multipliers);
    for (std::size_t i = 0; i < problem_.constraints().size(); ++i) {
      const NodeConstraint& constraint = problem_.constraints()[i];
      c.multipliers.segment(constraint.row, constraint.term->rows) =
          vector(multipliers["constraints"][i]["multiplier"], "multipliers.constraints");
    }
  }
  Eigen::MatrixXd gains_of_knot(const Json& K, int k) const {
    Eigen::MatrixXd gains(problem_.nu(k), problem_.ndx());
    const auto block = NumberBlock::of(K);
    Eigen::VectorXd row(problem_.ndx());
    for (int i = 0; i < problem_.nu(k); ++i) {
      const int at = controls_.are_some(k) ? controls_.columns_of(k)[i] : i;
      if (block)
        block->copy_row(static_cast<std::size_t>(at), row.data());
      else
        row = vector(K[at], "gains.K");
      gains.row(i) = row;
    }
    return gains;
  }
  void read_gains() {
    SolutionClaims& c = *claims_;
    const Json& gains = at(document_, {"gains"});
    const Json& K = gains["K"];
    const NumberTable feedforward(gains["k"], "gains.k");
    for (int k = 0; k < problem_.knots(); ++k) {
      c.gains[k] = gains_of_knot(K[k], k);
      copy_controls(feedforward, k, c.feedforward[k]);
    }
    c.gain_regularization = number(at(gains, {"regularization"}), "gains");
    c.gain_regularization_kind = spec_.solver.options.regularization.kind;
  }

  /// Compares the findings about the motion; answers of former versions contain none.
  void findings(const std::vector<Finding>& found) {
    if (!document_.contains("findings") || !claims_) return;
    const Json& list = solution_list(document_, "findings");
    const Json expected = findings_json(found);
    Check check{"findings"};
    if (list.size() != expected.size())
      check.message =
          fmt::format("{} in the answer, {} in its motion", list.size(), expected.size());
    for (std::size_t i = 0; check.message.empty() && i < expected.size(); ++i)
      check.message = first_difference(list[i], expected[i], found[i]);
    check.holds = check.message.empty();
    add(std::move(check));
  }

  /// The first differing figure of a finding, in words.
  static std::string first_difference(const Json& claims, const Json& expected,
                                      const Finding& found) {
    for (const auto& [key, value] : expected.items()) {
      const Json& claimed = at(claims, {key.c_str()});
      if (key == "message" || key == "remedy") continue;
      if (!is_same_figure(claimed, value))
        return fmt::format("'{}' of {} of {}: {} in the answer, {} in its motion", key,
                           to_string(found.kind), found.subject, claimed.dump(), value.dump());
    }
    return {};
  }
  static bool is_same_figure(const Json& claimed, const Json& actual) {
    if (claimed == actual) return true;
    const double here = actual.is_number_float() ? actual.get<double>() : Check::kNone;
    if (claimed.is_null()) return actual.is_number() && !std::isfinite(here);
    return claimed.is_number() && std::isfinite(here) &&
           is_near(claimed.get<double>(), here, kValueTolerance);
  }

  /// Checks the duration and all figures about constraints: their values row by row, and the
  /// location of the largest violation of each.
  void evaluate_constraints() {
    const double duration = number(at(document_, {"problem", "duration_s"}), "duration_s");
    compare_number("duration", duration, problem_.times(claims_->trajectory).back(), 1e-12);
    const Eigen::VectorXd& values = values_->constraint();
    std::vector<Check> checks = compare_values(values);
    if (!std::ranges::all_of(checks, &Check::holds)) {
      value_tolerance_ =
          std::max(kValueTolerance, constraint_rounding(problem_, claims_->trajectory, *values_));
      checks = compare_values(values);
    }
    for (Check& check : checks) add(std::move(check));
    violations("constraints", violations_by_name(problem_, values));
    violations("soft_constraints", soft_violations(problem_, claims_->trajectory, values));
  }

  /// For each constraint name, the first row that differs, else the last row.
  std::vector<Check> compare_values(const Eigen::VectorXd& values) {
    std::vector<Check> checks;
    for (std::size_t i = 0; i < problem_.constraints().size(); ++i) {
      const NodeConstraint& c = problem_.constraints()[i];
      const Json& list = at(at(document_, {"multipliers", "constraints"})[i], {"value"});
      const std::string name = "values of " + named(c);
      size(name, list, c.term->rows);
      const Eigen::VectorXd claimed = vector(list, "value");
      auto check = std::find_if(checks.begin(), checks.end(),
                                [&](const Check& known) { return known.name == name; });
      if (check == checks.end()) check = checks.insert(checks.end(), Check{name});
      for (int row = 0; row < std::min<int>(c.term->rows, static_cast<int>(claimed.size())); ++row)
        if (check->holds)
          *check = compared(name, claimed[row], values[c.row + row], value_tolerance_,
                            place_text(problem_, c.node, ""));
    }
    return checks;
  }

  void violations(const char* key, const std::vector<ConstraintViolation>& found) {
    if (found.empty() && !document_.contains(key)) return;
    const Json& list = solution_list(document_, key);
    size(key, list, static_cast<int>(found.size()));
    for (std::size_t i = 0; i < std::min(list.size(), found.size()); ++i) {
      if (!statement(key, at(list[i], {"name"}), found[i].name)) continue;
      const double claimed = number(at(list[i], {"violation"}), "violation");
      compare_number("violation of " + found[i].name, claimed, found[i].value, value_tolerance_);
      compare_place(key, at(list[i], {"node"}), found[i], claimed);
    }
  }

  /// Checks the node of the largest violation. If rounding decides, any equivalent node or −1 is
  /// accepted.
  void compare_place(const char* key, const Json& claimed, const ConstraintViolation& found,
                     double violation) {
    if (claimed == found.node || std::isnan(violation)) return;
    const double tolerance = value_tolerance_ * std::max(1.0, std::abs(found.value));
    if (claimed == -1 && found.value <= tolerance) return;
    const auto is_as_large = [&](const NodeConstraint& c) {
      return claimed == c.node && named(c) == found.name &&
             distance_to_set(*c.term, values_->constraint().data() + c.row, c.lower, c.upper) >=
                 found.value - tolerance;
    };
    if (std::ranges::any_of(problem_.constraints(), is_as_large) ||
        std::ranges::any_of(problem_.soft_constraints(), is_as_large))
      return;
    fail(fmt::format("{} {}", key, found.name),
         fmt::format("largest at node {}, not {}", found.node, claimed.dump()));
  }

  std::string named(const NodeConstraint& c) const { return constraint_name(problem_, c); }

  Check compared(std::string name, double claimed, double found, double tolerance,
                 std::string place = {}) const {
    const bool holds = open_or_near(claimed, found, tolerance);
    return {std::move(name),
            holds,
            claimed,
            found,
            tolerance * std::max(1.0, std::abs(found)),
            holds ? "" : std::move(place),
            ""};
  }
  void compare_number(std::string name, double claimed, double found, double tolerance) {
    add(compared(std::move(name), claimed, found, tolerance));
  }

  /// Checks the error of a refined grid; null stands for infinity.
  void error_of_grid() {
    statement("error asked of the grid", at(document_, {"mesh", "asked"}),
              spec_.mesh ? Json(spec_.mesh->error) : Json());
    const double claimed = number(at(document_, {"mesh", "error"}), "mesh.error");
    const double found = replay_error(problem_, claims_->trajectory);
    Check check = compared("error of the grid", claimed, found, kGridTolerance);
    if (std::isnan(claimed)) check.holds = !std::isfinite(found);
    add(std::move(check));
    if (spec_.mesh && found > spec_.mesh->error)
      grid_warning_ = fmt::format("grid error {:.1e}, more than {:.1e}", found, spec_.mesh->error);
  }

  /// Compiled code provides its own derivatives, on which the gradient of the Lagrangian depends.
  /// An answer without finite values cannot be compared.
  void derivatives_of_code() {
    if (!values_->all_finite()) return;
    Check check{
        .name = "derivatives of compiled code", .found = 0, .tolerance = kDerivativeTolerance};
    bool second = false;  // true if the worst error is in a second derivative
    for (const DerivativeComparison& worst : check_derivatives(problem_, claims_->trajectory)) {
      if (worst.error <= check.found) continue;
      check.found = worst.error;
      second = worst.kind == DerivativeKind::hessian;
      check.place = place_text(problem_, worst.knot, "");
    }
    check.holds = check.found <= kDerivativeTolerance;
    if (check.holds)
      check.place.clear();
    else
      check.message = second ? "its Hessian differs from differences of its Jacobian"
                      : std::isfinite(check.found)
                          ? "they differ from differences of its values"
                          : "the function fails or is not finite there or nearby";
    add(std::move(check));
  }

  void dropped() {
    const Json& list = at(document_, {"dropped_constraints"});
    size("dropped_constraints", list, static_cast<int>(built_.dropped.size()));
    for (std::size_t i = 0; i < std::min(list.size(), built_.dropped.size()); ++i) {
      const DroppedConstraint& constraint = built_.dropped[i];
      if (!statement("dropped constraint", at(list[i], {"name"}), constraint.name)) continue;
      const double claimed = number(at(list[i], {"violation"}), "violation");
      const double found = violation(constraint, problem_, claims_->trajectory);
      add({"violation of dropped " + constraint.name, open_or_near(claimed, found, 1e-12), claimed,
           found, 1e-12 * std::max(1.0, std::abs(found)), "", ""});
    }
  }

  bool open_or_near(double claimed, double found, double tolerance) const {
    if (std::isnan(claimed)) return claims_->status == to_string(SolveStatus::diverged);
    return is_near(claimed, found, tolerance);
  }
  static bool is_near(double claimed, double found, double tolerance) {
    return std::abs(claimed - found) <= tolerance * std::max(1.0, std::abs(found));
  }

  void forces() {
    const ContactForces found = contact_forces(spec_, problem_, *values_);
    const Json& claimed = at(document_, {"trajectory", "contact_forces"});
    size("contact_forces", claimed, found.contacts);
    for (const auto& contact : found.contacts)
      add(check_force(contact, at(claimed, {contact.name.c_str()})));
  }

  /// The worst figure, or the first wrong one.
  Check check_force(const ContactForces::OfContact& contact, const Json& rows) const {
    Check check{"force of " + contact.name};
    const int width = contact.torque ? 6 : 3;
    double worst = -1;
    const Json missing = "missing";
    for (int k = 0; k < problem_.knots() && check.holds; ++k) {
      const Json& row = k < static_cast<int>(rows.size()) ? rows[k] : missing;
      const auto& wrench = contact.wrench[k];
      check.message = defect_of_force(row, wrench.has_value(), width);
      check.holds = check.message.empty();
      if (wrench && check.holds) {
        const Eigen::VectorXd claimed = vector(row, "contact_forces");
        for (int i = 0; check.holds && i < width; ++i)
          compare_force(claimed[i], (*wrench)[i], worst, check);
      }
      if (!check.holds) check.place = place_text(problem_, k, "");
    }
    return check;
  }
  static const char* defect_of_force(const Json& row, bool held, int width) {
    if (!held) return row.is_null() ? "" : "the contact is not held here";
    const auto block = NumberBlock::of(row);
    const bool is_list = row.is_array() || (block && !block->is_table());
    const bool fits = is_list && static_cast<int>(*entries_of(row)) == width;
    return fits ? "" : "a force should stand here";
  }
  /// Records this figure in the check if it is worse than those before, or wrong.
  static void compare_force(double claim, double force, double& worst, Check& check) {
    const double size = std::abs(claim - force) / std::max(1.0, std::abs(force));
    if (!(size > worst) && !std::isnan(size)) return;
    if (std::isnan(claim) && !std::isfinite(force)) return;
    worst = size;
    check.claimed = claim;
    check.found = force;
    check.tolerance = kForceTolerance * std::max(1.0, std::abs(force));
    check.holds = size <= kForceTolerance;
  }

  void size(const std::string& name, const Json& object,
            const std::vector<ContactForces::OfContact>& contacts) {
    if (object.is_object() && object.size() == contacts.size()) return;
    fail(name, fmt::format("of {} contacts in the answer, {} in the problem", object.size(),
                           contacts.size()));
  }

  /// The last row of the log must be the answer itself, and rows must count iterations.
  void log() {
    const Json& log = solution_list(document_, "log");
    if (log.empty()) return;
    const Json& last = log.back();
    statement("iterations", at(document_, {"iterations"}), at(last, {"iteration"}));
    compare_number("cost in the log", number(at(last, {"cost"}), "log"), claims_->cost, 1e-12);
    compare_number("gap in the log", number(at(last, {"gap"}), "log"), claims_->gap, 1e-12);
    compare_number("violation in the log", number(at(last, {"constraint"}), "log"),
                   claims_->constraint, 1e-12);
    if (claims_->converged)
      compare_number("stationarity in the log", number(at(last, {"stationarity"}), "log"),
                     claims_->stationarity, 1e-12);
    count_rows(log);
  }

  void count_rows(const Json& log) {
    for (std::size_t i = 0; i < log.size(); ++i) {
      const Json& count = at(log[i], {"iteration"});
      const Json& before = i == 0 ? count : log[i - 1]["iteration"];
      if (count.is_number_integer() && (i == 0 ? count == 0 : count >= before)) continue;
      return fail("rows of the log", fmt::format("row {} is of iteration {}", i, count.dump()));
    }
  }

  /// For an answer that did not converge: checks that the figures do not contradict the status.
  void status() {
    const std::string wrong = what_denies(claims_->status);
    if (!wrong.empty()) fail("status", fmt::format("'{}', but {}", claims_->status, wrong));
  }
  std::string what_denies(const std::string& status) const {
    const SolverOptions& options = spec_.solver.options;
    if (status == to_string(SolveStatus::max_iterations))
      return at(document_, {"iterations"}) < options.max_iterations ? "fewer iterations" : "";
    if (status == to_string(SolveStatus::time_limit))
      return std::isfinite(options.max_time_s) ? "" : "there was none";
    if (status == to_string(SolveStatus::infeasible))
      return claims_->constraint <= options.tolerances.constraint ? "the constraints hold" : "";
    for (const SolveStatus other :
         {SolveStatus::converged, SolveStatus::cost_settled, SolveStatus::line_search_failed,
          SolveStatus::regularization_limit, SolveStatus::diverged, SolveStatus::interrupted})
      if (status == to_string(other)) return "";
    return "there is no such status";
  }

  /// Counts nulls.
  void nulls() {
    if (!document_.contains("nulls")) return;
    const Json& list = solution_list(document_, "nulls");
    for (const Json& entry : list) {
      const std::string key = solution_text(entry, "key");
      std::string pointer = "/" + key;
      std::replace(pointer.begin(), pointer.end(), '.', '/');
      const Json::json_pointer place(pointer);
      const int found = document_.contains(place) ? count_nulls(document_.at(place)) : 0;
      statement("nulls of " + key, at(entry, {"count"}), found);
    }
  }

  /// Compares the certificate in the answer with this one.
  void former_certificate() {
    if (!document_.contains("certificate")) return;
    const Json& former = document_.at("certificate");
    statement("certificate", at(former, {"holds"}), certificate_.holds());
    if (former.contains("verdict")) verdict(solution_text(former, "verdict"));
    if (former.contains("optimality")) optimality(former.at("optimality"));
    if (former.contains("second_order")) second_order(former.at("second_order"));
    const Json& list = solution_list(former, "checks");
    // Checks of the certificate itself come last.
    for (std::size_t i = 0; i < list.size(); ++i) {
      const std::string name = solution_text(list[i], "name");
      if (i >= certificate_.checks.size() || certificate_.checks[i].name != name)
        return fail("certificate of " + name, "is another check here");
      if (!says_the_same(list[i], certificate_.checks[i]))
        return fail("certificate of " + name, "differs from the result found here");
    }
  }

  static bool says_the_same(const Json& former, const Check& check) {
    const auto agrees = [&](const char* key, double mine, double allowed) {
      const double told = former.contains(key) ? number(former.at(key), key) : Check::kNone;
      if (std::isnan(told) && !std::isfinite(mine)) return true;
      return std::abs(told - mine) <= allowed;
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
    const std::string_view mine = to_string(certificate_.verdict());
    if (coarse(told) != coarse(mine))
      fail("certificate of verdict", fmt::format("'{}' in the answer, '{}' here", told, mine));
  }

  /// Compares the second-order figures, in the unit of the cost.
  void second_order(const Json& former) {
    if (!certificate_.second_order)
      return fail("certificate of second order", "the answer did not converge");
    const SecondOrder& o = *certificate_.second_order;
    const std::pair<const char*, double> figures[] = {
        {"bend", o.bend},   {"gain", o.gain},           {"repair", o.repair},
        {"slope", o.slope}, {"cost_size", o.cost_size}, {"resolution", o.resolution}};
    for (const auto& [key, mine] : figures) {
      const double told = number(at(former, {key}), key);
      if (std::isnan(told) && !std::isfinite(mine)) continue;
      if (std::abs(told - mine) <= 1e-3 * (std::abs(mine) + o.cost_size)) continue;
      add({"certificate of second order", false, told, mine, Check::kNone, "",
           fmt::format("'{}' is {:.3g} in the answer, {:.3g} here", key, told, mine)});
    }
  }

  /// Former figures must be reproduced up to rounding.
  void optimality(const Json& former) {
    const Optimality& o = certificate_.optimality;
    const std::tuple<const char*, double, double> figures[] = {
        {"stationarity", o.stationarity, o.rounding},
        {"rounding", o.rounding, o.rounding},
        {"reduced_gradient", o.reduced_gradient, o.reduced_rounding},
        {"reduced_rounding", o.reduced_rounding, o.reduced_rounding},
        {"expected_decrease", o.expected_decrease, kNewtonRounding}};
    for (const auto& [key, mine, rounding] : figures) {
      const double told = number(at(former, {key}), key);
      if (std::isnan(told) && !std::isfinite(mine)) continue;
      if (std::abs(told - mine) <= 1e-3 * std::abs(mine) + 10 * rounding) continue;
      add({"certificate of optimality", false, told, mine, Check::kNone, "",
           fmt::format("'{}' is {:.3g} in the answer, {:.3g} here", key, told, mine)});
    }
  }

  static constexpr double kNewtonRounding = 1e-12;
  static constexpr double kValueTolerance = 1e-10;
  static constexpr double kForceTolerance = 1e-9;
  static constexpr double kGridTolerance = 1e-9;

  /// Tolerance on constraint values, increased if rounding requires it.
  double value_tolerance_ = kValueTolerance;
  const Json& document_;
  const ProblemSpec& spec_;
  const BuiltProblem& built_;
  const ShootingProblem& problem_;
  const ControlColumns controls_;
  const Answer* const written_;  ///< null for a document from elsewhere
  std::optional<SolutionClaims> claims_;
  const NodeValues* values_ = nullptr;    ///< at the claimed trajectory, once it has been read
  std::optional<NodeValues> own_values_;  ///< set unless the values of `written` apply
  Certificate certificate_;
  std::string grid_warning_;
  bool fits_ = true;
};

}  // namespace

SolutionCertificate certify_solution(const OrderedJson& document, const ProblemSpec& spec,
                                     const BuiltProblem& built, bool with_replay,
                                     const Answer* written) {
  return Reader(document, spec, built, written).judge(with_replay);
}

}  // namespace conddp
