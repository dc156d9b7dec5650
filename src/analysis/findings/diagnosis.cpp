#include "analysis/findings/diagnosis.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "analysis/findings/free_control.hpp"
#include "analysis/findings/holding_torques.hpp"
#include "analysis/findings/singular_rate.hpp"
#include "ocp/problem/by_name.hpp"
#include "ocp/problem/cost_scale.hpp"
#include "solvers/iterate/hessian_switch.hpp"

namespace conddp {
namespace {

/// Number of log rows that are judged, and the fewest that show a pattern.
constexpr int kWindow = 10;
constexpr int kFewest = 4;
/// A quantity has stalled if it falls by less than this factor over the window.
constexpr double kStandstill = 0.5;
/// A violation above this many tolerances is not rounding.
constexpr double kFarOff = 1e3;
/// Rows of a long log; an interior-point method is judged over the second half of one.
constexpr std::size_t kLongLog = 40;

/// The end of a log: the rows of the last steps, and the row before them.
class Window {
 public:
  explicit Window(const std::vector<IterationRecord>& log)
      : log_(log), steps_(std::clamp(static_cast<int>(log.size()) - 1, 0, kWindow)) {}

  int steps() const { return steps_; }
  const IterationRecord& first() const { return log_[log_.size() - 1 - steps_]; }
  const IterationRecord& last() const { return log_.back(); }

  /// Number of steps with a property.
  template <class Property>
  int count(Property property) const {
    return static_cast<int>(std::count_if(log_.end() - steps_, log_.end(), property));
  }
  /// True if a quantity ends above half of its value at the start of the window. One good row
  /// between bad ones does not count as progress.
  bool stands_still(double IterationRecord::*quantity) const {
    return last().*quantity > kStandstill * first().*quantity;
  }
  double median_step() const {
    std::vector<double> steps;
    for (auto row = log_.end() - steps_; row != log_.end(); ++row) steps.push_back(row->step);
    std::nth_element(steps.begin(), steps.begin() + steps_ / 2, steps.end());
    return steps[steps_ / 2];
  }

 private:
  const std::vector<IterationRecord>& log_;
  int steps_;
};

/// True for the log of an interior-point method, whose steps follow a barrier instead of a penalty.
bool interior_point(const SolveResult& r) {
  return std::any_of(r.log.begin(), r.log.end(),
                     [](const IterationRecord& row) { return row.barrier > 0; });
}

std::string at(int knot) { return knot < 0 ? std::string() : fmt::format(" at knot {}", knot); }

/// Remedy for numbers that stop being finite: robots are stiff, and equations have poles and kinks.
/// If equations have no value at the start, shorter steps do not help.
std::string remedy_of_growth(const ShootingProblem& problem, const SolveResult& r, bool start,
                             bool without_value) {
  // Costs of robots are finite with derivatives, except those by expressions.
  const bool is_robot = problem.knot(0).model->system().robot_inside() != nullptr &&
                        r.failed_quantity != "cost gradient";
  const std::string guess =
      !start     ? ""
      : is_robot ? "another first guess (small controls, quasi_static, states near what is "
                   "possible), "
                 : "another first guess or initial state, away from where roots, norms, logarithms "
                   "and quotients have no derivative; ";
  if (is_robot)
    return guess +
           "a smaller dt or an integrator of higher order, smaller gains kp and kd of contacts; "
           "look for tiny masses and inertias ('conddp inspect')";
  return guess +
         "smooth_norm and smooth_abs in the place of norm, abs and roots of squares; bounds on the "
         "states where expressions are not finite" +
         (without_value ? "" : "; a smaller dt or an integrator of higher order");
}

/// Adds the state where equations lack a finite value, and a nearby one where they have it.
void tell_singular_rate(const SingularRate& at, const ShootingProblem& problem, Diagnosis& d) {
  const bool is_next = problem.knot(d.knot).model->system().kind() == SystemKind::discrete;
  d.message +=
      fmt::format(": the {} of '{}' is not finite there", is_next ? "next value" : "rate", at.row);
  if (at.state.empty()) return;
  d.message += fmt::format(", but would be with another '{}' than {:g}", at.state, at.value);
  d.remedy = fmt::format("'{}: {:g}' in {}, or equations that hold at {:g}, too; ", at.state,
                         at.nearby, d.knot == 0 ? "the initial state" : "the guess", at.value) +
             d.remedy;
}

/// "cost ('reach')" if one of the costs of the knot is not finite along the answer, otherwise only
/// the quantity.
std::string with_name(const ShootingProblem& problem, const SolveResult& r) {
  if (!r.failed_quantity.starts_with("cost") || r.failed_knot < 0) return r.failed_quantity;
  for (const auto& [name, costs] : costs_by_node(problem, NodeValues(problem, r.trajectory)))
    if (!std::isfinite(costs[r.failed_knot]))
      return fmt::format("{} ('{}')", r.failed_quantity, name);
  return r.failed_quantity;
}

/// Diagnosis of iterates that run away while their numbers are finite.
Diagnosis unbounded_iterates() {
  return {DiagnosisPattern::growth, "the iterates grow without bound", -1, "",
          "bounds on controls and states: a cost that is linear or negative may be unbounded "
          "below; another first guess"};
}

Diagnosis growth(const ShootingProblem& problem, const SolveResult& r) {
  if (r.iterations > 0 && r.status == SolveStatus::diverged && r.failed_quantity.empty() &&
      std::isfinite(r.cost))
    return unbounded_iterates();
  const bool start = r.iterations == 0;
  const std::string quantity = r.failed_quantity.empty() ? "motion" : with_name(problem, r);
  std::optional<SingularRate> singular;
  if (start && r.failed_knot >= 0 && r.failed_knot < problem.knots())
    singular = singular_rate(problem, r.trajectory, r.failed_knot);
  Diagnosis d{
      DiagnosisPattern::growth,
      fmt::format("the {}{} {}", quantity, at(r.failed_knot),
                  r.status == SolveStatus::diverged
                      ? (start ? "is not finite along the first guess" : "stopped being finite")
                      : "becomes infinite or NaN in every longer step"),
      r.failed_knot, r.failed_quantity,
      remedy_of_growth(problem, r, start, singular.has_value() || (start && r.failed_knot == 0))};
  if (singular) tell_singular_rate(*singular, problem, d);
  return d;
}

Diagnosis indefinite(const SolveResult& r) {
  return {DiagnosisPattern::indefinite,
          fmt::format("{} stays indefinite{} with the largest regularization", r.failed_quantity,
                      at(r.failed_knot)),
          r.failed_knot, r.failed_quantity, "a cost on every control of that knot"};
}

/// True if some control is unbounded.
bool has_free_controls(const ShootingProblem& problem) {
  return std::ranges::any_of(problem.phases(), [](const Phase& phase) {
    const KnotModel& model = *phase.model;
    for (int i = 0; i < model.nu(); ++i)
      if (!std::isfinite(model.control_lower()[i]) && !std::isfinite(model.control_upper()[i]))
        return true;
    return false;
  });
}

/// Remedy for a violation that remains. `least`: no nearby point has a smaller violation, and a few
/// guesses rarely change that.
std::string remedy_of_violation(const ShootingProblem& problem, bool least) {
  std::string remedy =
      "wider bounds, more time for the motion, or a solve without one constraint (--drop) to find "
      "the conflict; a minimum of the violation can also be local: ";
  remedy += least ? "many first guesses" : "another first guess, or many of them";
  remedy += " (solver.restarts: {count: 20, spread: 1})";
  if (has_free_controls(problem))
    remedy +=
        "; where controls without bounds have to become large, a larger "
        "solver.augmented_lagrangian.initial_penalty";
  return remedy;
}

/// `drawn`: a linear cost may have moved the minima of the penalties far away.
Diagnosis infeasible(const ShootingProblem& problem, const IterationRecord& last, bool drawn) {
  return {DiagnosisPattern::infeasible,
          fmt::format("no small change of the controls from here lowers the violation, {:.1e}{}",
                      last.constraint, at(last.constraint_knot)),
          last.constraint_knot, "constraint violation",
          remedy_of_violation(problem, true) +
              (drawn ? "; --solver ipopt, which a linear cost does not pull away from feasibility"
                     : "")};
}

/// Diagnosis after a restoration that reached neither feasibility nor a least violation.
Diagnosis undecided(const ShootingProblem& problem, const IterationRecord& last) {
  return {DiagnosisPattern::undecided,
          fmt::format("a restoration of feasibility did not reduce the violation below {:.1e}{}; "
                      "whether the constraints can be satisfied has not been decided",
                      last.constraint, at(last.constraint_knot)),
          last.constraint_knot, "constraint violation", remedy_of_violation(problem, false)};
}

/// Diagnosis of iterations whose violation has stalled.
Diagnosis stalled_violation(const ShootingProblem& problem, const IterationRecord& middle,
                            const IterationRecord& last) {
  return {DiagnosisPattern::undecided,
          fmt::format("the violation stalled: {:.1e}{} after {:.1e} {} iterations before; whether "
                      "the constraints can be satisfied has not been decided",
                      last.constraint, at(last.constraint_knot), middle.constraint,
                      last.iteration - middle.iteration),
          last.constraint_knot, "constraint violation", remedy_of_violation(problem, false)};
}

/// A residual above its tolerance.
struct Missed {
  const char* quantity;
  const char* option;  ///< key in solver.tolerances
  double value;
  int knot;
};

std::vector<Missed> missed(const Residuals& r, const SolverOptions::Tolerances& t) {
  std::vector<Missed> list;
  const auto look = [&](const Missed& m, double tolerance) {
    if (m.value > tolerance) list.push_back(m);
  };
  look({"gap", "gap", r.gap, r.gap_knot}, t.gap);
  look({"stationarity", "stationarity", r.stationarity, r.stationarity_knot}, t.stationarity);
  look({"constraint violation", "constraint", r.constraint, r.constraint_knot}, t.constraint);
  look({"complementarity", "complementarity", r.complementarity, -1}, t.complementarity);
  return list;
}

/// "stationarity 1.0e-05 at knot 3, complementarity 2.0e-06".
std::string figures(const std::vector<Missed>& list) {
  std::string text;
  for (const Missed& m : list)
    text += fmt::format("{}{} {:.1e}{}", text.empty() ? "" : ", ", m.quantity, m.value, at(m.knot));
  return text.empty() ? std::string("all residuals are under their tolerances") : text;
}

Diagnosis rounding_floor(const SolveResult& r, const SolverOptions::Tolerances& t) {
  const std::vector<Missed> list = missed(r.residuals, t);
  Diagnosis d{DiagnosisPattern::rounding_floor,
              "rounding of the cost hides what is left to gain: " + figures(list), -1, "", ""};
  bool stationary = true;
  std::string options;
  for (const Missed& m : list) {
    options += fmt::format("{}solver.tolerances.{}", options.empty() ? "" : ", ", m.option);
    stationary &= std::string_view(m.option) != "stationarity";
  }
  if (!list.empty()) {
    d.knot = list.front().knot;
    d.quantity = list.front().quantity;
    d.remedy = "a larger " + options + " (the answer is as good as the cost's digits allow), or ";
  }
  d.remedy += stationary && !list.empty()
                  ? "constraints in units in which their multipliers are smaller"
                  : "smaller weights of costs that stay large";
  return d;
}

Diagnosis open_gaps(const Window& w) {
  return {
      DiagnosisPattern::open_gaps,
      fmt::format("the gaps stay open: {:.1e}{}, {}", w.last().gap, at(w.last().gap_knot),
                  w.steps() == 0 ? std::string("and no step lowers the merit")
                                 : fmt::format("after {:.1e} {} steps before (median step {:.2g})",
                                               w.first().gap, w.steps(), w.median_step())),
      w.last().gap_knot, "gap",
      "states of the first guess that the controls can follow; more knots where the motion is "
      "fast; wider bounds on the control"};
}

Diagnosis outrun_penalty(const Window& w) {
  return {DiagnosisPattern::outrun_penalty,
          fmt::format("a linear cost gains more than the penalties of violated constraints cost: "
                      "cost {:.3g}, violation {:.1e}{} after {:.1e} {} steps before",
                      w.last().cost, w.last().constraint, at(w.last().constraint_knot),
                      w.first().constraint, w.steps()),
          w.last().constraint_knot, "constraint violation",
          "--solver ipopt, which has no penalties; bounds on the states and durations by which the "
          "cost falls"};
}

Diagnosis slow_feasibility(const Window& w) {
  return {DiagnosisPattern::slow_feasibility,
          fmt::format("full steps, but the violation falls slowly: {:.1e}{} after {:.1e} {} steps "
                      "before",
                      w.last().constraint, at(w.last().constraint_knot), w.first().constraint,
                      w.steps()),
          w.last().constraint_knot, "constraint violation",
          "a larger solver.augmented_lagrangian.initial_penalty"};
}

Diagnosis plateau(const Window& w, bool regularised) {
  std::string message = fmt::format(
      "stationarity stalled: {:.1e}{} after {:.1e} {} steps before, with {}", w.last().stationarity,
      at(w.last().stationarity_knot), w.first().stationarity, w.steps(),
      regularised ? fmt::format("regularization {:.1e}", w.last().regularization)
                  : fmt::format("steps of {:.2g}", w.median_step()));
  return {DiagnosisPattern::plateau, std::move(message), w.last().stationarity_knot, "stationarity",
          regularised ? "more iterations (solver.max_iterations), or exact Hessians "
                        "(solver.hessian: exact)"
                      : "exact Hessians (solver.hessian: exact), a first guess nearer to the "
                        "answer, smoother costs (smooth_l1 with a larger epsilon)"};
}

Diagnosis no_descent(const SolveResult& r, const SolverOptions& options,
                     const IterationRecord& last) {
  const std::string left = figures(missed(r.residuals, options.tolerances));
  return {DiagnosisPattern::no_descent, "no step lowers the merit: " + left, last.stationarity_knot,
          "merit",
          interior_point(r)
              ? "derivatives ('conddp check --derivatives'), costs and constraints that are not "
                "smooth, a first guess nearer to what is possible, solver.options: {mu_strategy: "
                "adaptive}"
          : r.residuals.gap > 0
              ? "derivatives ('conddp check --derivatives'), costs that are not smooth, a first "
                "guess with smaller gaps"
              : "derivatives ('conddp check --derivatives'), costs that are not smooth"};
}

Diagnosis unfinished(const SolveResult& r, const SolverOptions& options,
                     const IterationRecord& last) {
  const std::vector<Missed> list = missed(r.residuals, options.tolerances);
  Diagnosis d{
      DiagnosisPattern::unfinished,
      fmt::format("the solve stopped ({}) after {} iterations while it made progress: {}",
                  to_string(r.status), r.iterations, figures(list)),
      last.stationarity_knot, "stationarity",
      "more iterations or time (solver.max_iterations, --max-time), or go on from here with "
      "--warm-start"};
  if (!list.empty()) {
    d.knot = list.front().knot;
    d.quantity = list.front().quantity;
  }
  return d;
}

/// Contacts that depend on each other leave their forces to the compliance of a singular G. Steps
/// then fail for a reason that no solver option removes.
Diagnosis redundant(Diagnosis stuck, const ContactRank& contacts) {
  stuck.message +=
      fmt::format("; the contacts '{}' are redundant there: of all {} rows {} are independent",
                  fmt::join(contacts.redundant, "', '"), contacts.rows, contacts.rank);
  return {DiagnosisPattern::redundant_contacts, std::move(stuck.message), stuck.knot, "contacts",
          "contacts that constrain less (type: point, planar or normal instead of surface, or one "
          "fewer), joints that are not locked, or a posture in which limbs are bent"};
}

/// A robot that cannot stay at its initial state falls, whatever the solver does. If the solve
/// merely stopped too early, the advice from the log is kept.
Diagnosis too_weak(Diagnosis log, const MissingTorque& lack) {
  const std::string has =
      lack.driven ? fmt::format("its limit is {:.3g}", lack.limit) : "it has no control";
  log.message += fmt::format(
      "; no controls within their limits hold the initial state at rest: '{}' would need {:.3g} "
      "{}, {}",
      lack.joint, lack.needed, lack.unit, has);
  std::string remedy =
      "limits at the joints (those of a URDF may be of motors, before their gears); controls or "
      "locked_joints at joints that springs, rods or closed chains hold on the robot itself; "
      "another initial state";
  if (log.pattern == DiagnosisPattern::unfinished) remedy = log.remedy + "; " + remedy;
  return {DiagnosisPattern::no_static_equilibrium, std::move(log.message), log.knot, "controls",
          std::move(remedy)};
}

/// True if the cost falls in the second half of a log at least half as far as in the first.
bool cost_goes_on_falling(const std::vector<IterationRecord>& log) {
  const int last = static_cast<int>(log.size()) - 1;
  if (last < kFewest) return false;
  const double first = log.front().cost, middle = log[last / 2].cost, end = log[last].cost;
  return middle < first && middle - end >= 0.5 * (first - middle);
}

/// Diagnosis of a cost that drives a control without limit, whatever the log looks like.
Diagnosis unbounded(Diagnosis log, double cost, const FreeControl& control) {
  log.message += fmt::format(
      "; the cost keeps falling, to {:.3g}, and the control '{}' has neither a cost nor a bound in "
      "the phase '{}'",
      cost, control.name, control.phase);
  return {DiagnosisPattern::free_control, std::move(log.message), control.knot, control.name,
          "a cost on it ('{residual: control}') or bounds ('{bounds: control, lower: -1, upper: "
          "1}')"};
}

bool lost(const SolveResult& r) {
  if (r.status == SolveStatus::diverged || r.log.empty()) return true;
  const IterationRecord& last = r.log.back();
  return !std::isfinite(last.cost) || !std::isfinite(last.stationarity) || !std::isfinite(last.gap);
}

/// True if full steps reduce the violation by less than half each.
bool is_slowly_feasible(const Window& w, double tolerance) {
  const double left = w.last().constraint;
  const int full = w.count([](const IterationRecord& r) { return r.step >= 1; });
  return left > tolerance && full == w.steps() &&
         left > std::pow(kStandstill, w.steps()) * w.first().constraint;
}

/// Diagnosis of a solve that iterates without progress.
std::optional<Diagnosis> of_standstill(const Window& w, const SolverOptions& options) {
  if (w.steps() < kFewest) return std::nullopt;
  if (is_slowly_feasible(w, options.tolerances.constraint)) return slow_feasibility(w);
  if (w.last().stationarity <= options.tolerances.stationarity ||
      !w.stands_still(&IterationRecord::stationarity))
    return std::nullopt;
  const bool always =
      w.count([](const IterationRecord& r) { return r.regularization > 0; }) == w.steps();
  if (w.median_step() > 0.25 && !always) return std::nullopt;
  return plateau(w, always);
}

bool is_stuck(SolveStatus status) {
  return status == SolveStatus::line_search_failed || status == SolveStatus::regularization_limit;
}

Diagnosis of_interior_point(const ShootingProblem& problem, const SolveResult& result,
                            const SolverOptions& options) {
  const IterationRecord &middle = result.log[result.log.size() / 2], &last = result.log.back();
  if (is_stuck(result.status)) return no_descent(result, options, last);
  const bool stalled = result.log.size() >= kLongLog &&
                       last.constraint > kFarOff * options.tolerances.constraint &&
                       last.constraint > kStandstill * middle.constraint;
  return stalled ? stalled_violation(problem, middle, last) : unfinished(result, options, last);
}

/// True if the solve ended during a restoration of feasibility, far from feasible.
bool ends_restoring(const SolveResult& result, double tolerance) {
  const IterationRecord& last = result.log.back();
  return is_stuck(result.status) && last.restoration > 0 && last.constraint > kFarOff * tolerance;
}

bool violation_stands_still(const Window& w, double tolerance) {
  return w.last().constraint > kFarOff * tolerance && w.stands_still(&IterationRecord::constraint);
}

/// True if costs without curvature drive the iterates further away than the constraint penalties
/// pull them back.
bool outruns_penalty(const ShootingProblem& problem, const Window& w, double tolerance) {
  return violation_stands_still(w, tolerance) && w.last().cost <= w.first().cost &&
         has_linear_costs(problem);
}

bool is_rounding_floor(const SolveResult& result, double tolerance) {
  return result.failed_quantity == kRoundedCost &&
         result.residuals.constraint <= kFarOff * tolerance;
}

bool gaps_stay_open(const SolveResult& result, const Window& w, double tolerance) {
  if (!(w.last().gap > tolerance)) return false;
  if (result.status == SolveStatus::line_search_failed && result.failed_knot < 0) return true;
  return w.steps() >= kFewest && w.stands_still(&IterationRecord::gap);
}

/// Diagnosis of a solve that did not converge, from its log only.
Diagnosis of_log(const ShootingProblem& problem, const SolveResult& result,
                 const SolverOptions& options) {
  if (lost(result)) return growth(problem, result);
  if (result.status == SolveStatus::infeasible)
    return infeasible(problem, result.log.back(),
                      !interior_point(result) && has_linear_costs(problem));
  if (ends_restoring(result, options.tolerances.constraint))
    return undecided(problem, result.log.back());
  if (interior_point(result)) return of_interior_point(problem, result, options);
  if (result.status == SolveStatus::regularization_limit) return indefinite(result);
  const Window w(result.log);
  if (outruns_penalty(problem, w, options.tolerances.constraint)) return outrun_penalty(w);
  if (is_rounding_floor(result, options.tolerances.constraint))
    return rounding_floor(result, options.tolerances);
  if (gaps_stay_open(result, w, options.tolerances.gap)) return open_gaps(w);
  auto standstill = of_standstill(w, options);
  // Far from feasible, neither regularization nor more iterations matter.
  const bool is_vain =
      standstill ? standstill->pattern == DiagnosisPattern::plateau : result.log.size() >= kLongLog;
  if (is_vain && violation_stands_still(w, options.tolerances.constraint))
    return stalled_violation(problem, w.first(), w.last());
  if (standstill) return *std::move(standstill);
  if (result.status != SolveStatus::line_search_failed)
    return unfinished(result, options, w.last());
  return result.failed_knot >= 0 ? growth(problem, result) : no_descent(result, options, w.last());
}

/// True if a stalled solve may only need more iterations than allowed.
bool wants_iterations(const SolveResult& result, DiagnosisPattern pattern) {
  if (result.status != SolveStatus::max_iterations) return false;
  if (pattern == DiagnosisPattern::slow_feasibility) return true;
  return result.log.size() < kLongLog &&
         (pattern == DiagnosisPattern::open_gaps || pattern == DiagnosisPattern::undecided);
}

bool is_stuck_at_knot(DiagnosisPattern pattern) {
  return pattern == DiagnosisPattern::open_gaps || pattern == DiagnosisPattern::plateau ||
         pattern == DiagnosisPattern::no_descent;
}

}  // namespace

std::string_view to_string(DiagnosisPattern pattern) {
  constexpr std::string_view kNames[] = {
      "normal",       "growth",         "indefinite",         "infeasible",
      "undecided",    "rounding_floor", "redundant_contacts", "no_static_equilibrium",
      "free_control", "open_gaps",      "outrun_penalty",     "slow_feasibility",
      "plateau",      "no_descent",     "unfinished"};
  return kNames[static_cast<int>(pattern)];
}

Diagnosis diagnose(const ShootingProblem& problem, const SolveResult& result,
                   const SolverOptions& options) {
  if (is_success(result.status))
    return {DiagnosisPattern::normal,
            fmt::format("{} in {} iterations",
                        result.status == SolveStatus::converged
                            ? "normal convergence"
                            : "the cost settled by tolerances.cost_decrease",
                        result.iterations),
            -1, "", ""};
  SolverOptions own = options;  // in the unit of the costs, like the log
  own.tolerances.stationarity /= cost_scale(problem);
  Diagnosis d = of_log(problem, result, own);
  if (wants_iterations(result, d.pattern))
    d.remedy = "more iterations (solver.max_iterations); " + d.remedy;
  if (result.status != SolveStatus::interrupted)
    if (const auto lack = missing_torque(problem)) return too_weak(std::move(d), *lack);
  if (cost_goes_on_falling(result.log))
    if (const auto control = free_control(problem))
      return unbounded(std::move(d), result.log.back().cost, *control);
  if (!is_stuck_at_knot(d.pattern) || d.knot < 0 || d.knot >= problem.knots()) return d;
  const ContactRank contacts =
      problem.knot(d.knot).model->system().contact_rank(result.trajectory.x(d.knot).data());
  return contacts.redundant.empty() ? d : redundant(std::move(d), contacts);
}

}  // namespace conddp
