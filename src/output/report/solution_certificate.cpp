#include "output/report/solution_certificate.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "analysis/certificate/check.hpp"
#include "analysis/derivatives/derivative_check.hpp"
#include "base/json/json_document.hpp"
#include "base/stopwatch.hpp"
#include "output/report/document_claims.hpp"
#include "output/solution/finding_report.hpp"
#include "output/solution/free_numbers.hpp"
#include "problem_file/assemble/problem_names.hpp"

namespace conddp {
namespace {

constexpr double kValueTolerance = 1e-10, kForceTolerance = 1e-9, kGridTolerance = 1e-9;
/// Rounding of figures that are copied or summed alike.
constexpr double kCopied = 1e-12;

/// Judges the claims of an answer to a problem of a file.
class AnswerJudge {
 public:
  /// `values` are those at the claimed trajectory. All arguments must outlive this object.
  AnswerJudge(const AnswerClaims& claims, const BuiltProblem& built, const NodeValues& values,
              SolutionCertificate& result)
      : claims_(claims),
        numbers_(claims.solution),
        built_(built),
        problem_(*built.problem),
        values_(values),
        result_(result) {}

  /// Adds all checks. `known` is the certificate of the claimed numbers.
  void judge(Certificate known, bool with_replay) {
    std::vector<Check>& checks = result_.checks.checks;
    known.checks.insert(known.checks.begin(), checks.begin(), checks.end());
    result_.checks = std::move(known);
    compare_number("duration", claims_.duration, problem_.times(numbers_.trajectory).back(),
                   kCopied);
    free_numbers();
    constraint_values();
    violations("constraints", claims_.violations,
               violations_by_name(problem_, values_.constraint()));
    violations("soft_constraints", claims_.soft_violations,
               soft_violations(problem_, numbers_.trajectory, values_.constraint()));
    if (runs_code(built_)) derivatives_of_code();
    if (claims_.grid_error) error_of_grid(claims_.grid_error->first, claims_.grid_error->second);
    dropped();
    forces();
    log();
    if (const std::string wrong = what_denies(numbers_.status); !wrong.empty())
      fail("status", fmt::format("'{}', but {}", numbers_.status, wrong));
    result_.converged = numbers_.converged;
    if (with_replay) result_.replay = replay(problem_, numbers_.trajectory, numbers_.gains);
    contacts(with_replay);
  }

 private:
  void add(Check check) { result_.checks.checks.push_back(std::move(check)); }
  void fail(std::string name, std::string message) {
    add({.name = std::move(name), .holds = false, .message = std::move(message)});
  }
  /// Adds a check that two texts or numbers are equal.
  template <class T>
  bool expect(const char* name, const T& claimed, const T& actual) {
    if (claimed != actual)
      fail(name, fmt::format("{} in the answer, {} in the problem", claimed, actual));
    else
      add({name});
    return claimed == actual;
  }
  /// True if lists have the same length; otherwise adds a failed check.
  bool have_one_size(const char* name, std::size_t claimed, std::size_t actual) {
    if (claimed != actual)
      fail(name, fmt::format("{} entries in the answer, {} in the problem", claimed, actual));
    return claimed == actual;
  }

  /// Only a diverged answer may leave numbers open.
  Check compared(std::string name, double claimed, double found, double tolerance,
                 std::string place = {}) const {
    const double allowed = tolerance * std::max(1.0, std::abs(found));
    const bool holds = std::isnan(claimed) ? numbers_.status == to_string(SolveStatus::diverged)
                                           : std::abs(claimed - found) <= allowed;
    return {std::move(name), holds, claimed, found, allowed, holds ? "" : std::move(place), ""};
  }
  void compare_number(std::string name, double claimed, double found, double tolerance) {
    add(compared(std::move(name), claimed, found, tolerance));
  }

  /// Values follow from the trajectory, so that other differences are edits.
  void free_numbers() {
    const auto found = conddp::free_numbers(built_, numbers_.trajectory);
    if (!have_one_size("free_numbers", claims_.free_numbers.size(), found.size())) return;
    for (std::size_t i = 0; i < found.size(); ++i) {
      FreeNumber claimed = claims_.free_numbers[i];
      compare_number(found[i].name, claimed.value, found[i].value, kCopied);
      claimed.value = found[i].value;
      if (claimed != found[i])
        fail(found[i].name, "name, unit or limit are others than in the problem");
    }
  }

  /// Compares the values of constraints row by row, more loosely if rounding requires it.
  void constraint_values() {
    std::vector<Check> checks = compare_values();
    if (!std::ranges::all_of(checks, &Check::holds)) {
      value_tolerance_ =
          std::max(kValueTolerance, constraint_rounding(problem_, numbers_.trajectory, values_));
      checks = compare_values();
    }
    for (Check& check : checks) add(std::move(check));
  }

  /// For each constraint name, the first row that differs, else the last row.
  std::vector<Check> compare_values() const {
    std::vector<Check> checks;
    for (const NodeConstraint& c : problem_.constraints()) {
      const std::string name = "values of " + constraint_name(problem_, c);
      auto check = std::ranges::find(checks, name, &Check::name);
      if (check == checks.end()) check = checks.insert(checks.end(), Check{name});
      for (int row = c.row; row < c.row + c.term->rows; ++row)
        if (check->holds)
          *check = compared(name, claims_.constraint_values[row], values_.constraint()[row],
                            value_tolerance_, place_text(problem_, c.node, ""));
    }
    return checks;
  }

  void violations(const char* key, const std::vector<ConstraintViolation>& claimed,
                  const std::vector<ConstraintViolation>& found) {
    have_one_size(key, claimed.size(), found.size());
    for (std::size_t i = 0; i < std::min(claimed.size(), found.size()); ++i) {
      if (!expect(key, claimed[i].name, found[i].name)) continue;
      compare_number("violation of " + found[i].name, claimed[i].value, found[i].value,
                     value_tolerance_);
      compare_place(key, claimed[i], found[i]);
    }
  }

  /// Checks the node of the largest violation. If rounding decides, any equivalent node or −1 is
  /// accepted.
  void compare_place(const char* key, const ConstraintViolation& claimed,
                     const ConstraintViolation& found) {
    if (claimed.node == found.node || std::isnan(claimed.value)) return;
    const double tolerance = value_tolerance_ * std::max(1.0, std::abs(found.value));
    if (claimed.node == -1 && found.value <= tolerance) return;
    const auto is_as_large = [&](const NodeConstraint& c) {
      return claimed.node == c.node && constraint_name(problem_, c) == found.name &&
             distance_to_set(*c.term, values_.constraint().data() + c.row, c.lower, c.upper) >=
                 found.value - tolerance;
    };
    if (std::ranges::any_of(problem_.constraints(), is_as_large) ||
        std::ranges::any_of(problem_.soft_constraints(), is_as_large))
      return;
    fail(fmt::format("{} {}", key, found.name),
         fmt::format("largest at node {}, not {}", found.node, claimed.node));
  }

  /// Compiled code provides its own derivatives, on which the gradient of the Lagrangian depends.
  /// An answer without finite values cannot be compared.
  void derivatives_of_code() {
    if (!values_.all_finite()) return;
    Check check{
        .name = "derivatives of compiled code", .found = 0, .tolerance = kDerivativeTolerance};
    bool second = false;  // true if the worst error is in a second derivative
    for (const DerivativeComparison& worst : check_derivatives(problem_, numbers_.trajectory)) {
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

  /// Checks the error of a refined grid; an open one stands for infinity.
  void error_of_grid(double claimed, double asked) {
    const std::optional<MeshSpec>& mesh = built_.facts().mesh;
    expect("error asked of the grid", asked, mesh ? mesh->error : Check::kNone);
    const double found = replay_error(problem_, numbers_.trajectory);
    Check check = compared("error of the grid", claimed, found, kGridTolerance);
    if (std::isnan(claimed)) check.holds = !std::isfinite(found);
    add(std::move(check));
    if (mesh && found > mesh->error)
      result_.grid_warning = fmt::format("grid error {:.1e}, more than {:.1e}", found, mesh->error);
  }

  void dropped() {
    const std::vector<DroppedConstraint>& all = built_.dropped;
    have_one_size("dropped_constraints", claims_.dropped.size(), all.size());
    for (std::size_t i = 0; i < std::min(claims_.dropped.size(), all.size()); ++i)
      if (expect("dropped constraint", claims_.dropped[i].first, all[i].name))
        compare_number("violation of dropped " + all[i].name, claims_.dropped[i].second,
                       violation(all[i], problem_, numbers_.trajectory), kCopied);
  }

  void forces() {
    const ContactForces found = contact_forces(built_, values_);
    for (std::size_t i = 0; i < found.contacts.size(); ++i)
      add(check_force(claims_.forces.contacts[i], found.contacts[i]));
  }

  /// The worst figure, or the first wrong one.
  Check check_force(const ContactForces::OfContact& claimed,
                    const ContactForces::OfContact& found) const {
    Check check{"force of " + found.name};
    double worst = -1;
    for (int k = 0; k < problem_.knots() && check.holds; ++k) {
      const auto &claim = claimed.wrench[k], &force = found.wrench[k];
      check.holds = claim.has_value() == force.has_value();
      if (!check.holds)
        check.message = force ? "a force should stand here" : "the contact is not held here";
      for (int i = 0; check.holds && force && i < (found.torque ? 6 : 3); ++i)
        compare_force((*claim)[i], (*force)[i], worst, check);
      if (!check.holds) check.place = place_text(problem_, k, "");
    }
    return check;
  }
  /// Records this figure in the check if it is worse than those before, or wrong.
  static void compare_force(double claim, double force, double& worst, Check& check) {
    const double size = std::abs(claim - force) / std::max(1.0, std::abs(force));
    if (!(size > worst) && !std::isnan(size)) return;
    if (!std::isfinite(claim) && !std::isfinite(force)) return;
    worst = size;
    check.claimed = claim;
    check.found = force;
    check.tolerance = kForceTolerance * std::max(1.0, std::abs(force));
    check.holds = size <= kForceTolerance;
  }

  /// The last row of the log must be the answer itself, and rows must count iterations.
  void log() {
    const std::vector<IterationRecord>& log = claims_.log;
    if (log.empty()) return;
    const IterationRecord& last = log.back();
    expect("iterations", claims_.iterations, last.iteration);
    compare_number("cost in the log", last.cost, numbers_.cost, kCopied);
    compare_number("gap in the log", last.gap, numbers_.gap, kCopied);
    compare_number("violation in the log", last.constraint, numbers_.constraint, kCopied);
    if (numbers_.converged)
      compare_number("stationarity in the log", last.stationarity, numbers_.stationarity, kCopied);
    for (std::size_t i = 0; i < log.size(); ++i)
      if (i == 0 ? log[i].iteration != 0 : log[i].iteration < log[i - 1].iteration)
        return fail("rows of the log",
                    fmt::format("row {} is of iteration {}", i, log[i].iteration));
  }

  /// The figure of an answer that did not converge that contradicts its status.
  std::string what_denies(const std::string& status) const {
    const SolverOptions& options = built_.facts().solver.options;
    if (status == to_string(SolveStatus::max_iterations))
      return claims_.iterations < options.max_iterations ? "fewer iterations" : "";
    if (status == to_string(SolveStatus::time_limit))
      return std::isfinite(options.max_time_s) ? "" : "there was none";
    if (status == to_string(SolveStatus::infeasible))
      return numbers_.constraint <= options.tolerances.constraint ? "the constraints hold" : "";
    for (const SolveStatus other :
         {SolveStatus::converged, SolveStatus::cost_settled, SolveStatus::line_search_failed,
          SolveStatus::regularization_limit, SolveStatus::diverged, SolveStatus::interrupted})
      if (status == to_string(other)) return "";
    return "there is no such status";
  }

  /// Checks contact-implicit problems; only converged answers make claims about contacts.
  void contacts(bool with_replay) {
    const auto motion = contact_motion(problem_, numbers_.trajectory);
    if (!motion) return;
    result_.contacts = certify_contacts(*motion);
    if (numbers_.converged)
      for (Check& check : contact_checks(
               *motion, result_.contacts->measures, numbers_.tolerances,
               [&](int k, const std::string&what) { return place_text(problem_, k, what); }))
        add(std::move(check));
    if (with_replay) result_.contacts->replay = replay_contacts(*motion, numbers_.gains);
  }

  /// Tolerance on constraint values, increased if rounding requires it.
  double value_tolerance_ = kValueTolerance;
  const AnswerClaims& claims_;
  const SolutionClaims& numbers_;
  const BuiltProblem& built_;
  const ShootingProblem& problem_;
  const NodeValues& values_;
  SolutionCertificate& result_;
};

}  // namespace

SolutionCertificate certify_answer(const Solution& solution) {
  double seconds = 0;
  SolutionCertificate result{.findings = solution.answer.findings,
                             .tangent_names = tangent_columns(solution.built)};
  {
    const Stopwatch watch(seconds);
    const ShootingProblem& problem = *solution.built.problem;
    for (std::string& name : statement_names(problem))
      result.checks.checks.push_back({std::move(name)});
    const AnswerClaims claims = answer_claims(solution);
    const NodeValues& values = solution.answer.values;
    AnswerJudge(claims, solution.built, values, result)
        .judge(certify(problem, claims.solution, values, solution.answer.judged.get()), false);
    result.checks.checks.push_back({"findings"});
  }
  result.time_s = seconds;
  return result;
}

void note_nulls(const OrderedJson& document, Certificate& certificate) {
  for (const OrderedJson& entry : document.at("nulls"))
    certificate.checks.push_back({"nulls of " + entry.at("key").get<std::string>()});
}

SolutionCertificate certify_solution(const OrderedJson& document, const BuiltProblem& built,
                                     bool with_replay) {
  double seconds = 0;
  SolutionCertificate result{.tangent_names = tangent_columns(built)};
  {
    const Stopwatch watch(seconds);
    if (const auto claims = read_claims(document, built, result.checks.checks)) {
      const SolutionClaims& numbers = claims->solution;
      const NodeValues values(*built.problem, numbers.trajectory);
      AnswerJudge(*claims, built, values, result)
          .judge(certify(*built.problem, numbers, values), with_replay);
      result.findings = findings_of(built, numbers.trajectory, numbers.gains, values);
      if (document.contains("findings"))
        result.checks.checks.push_back(
            findings_check(solution_list(document, "findings"), result.findings));
    }
    check_nulls_and_certificate(document, result.checks);
  }
  result.time_s = seconds;
  return result;
}

}  // namespace conddp
