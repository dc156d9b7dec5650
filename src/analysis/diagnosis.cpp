#include "analysis/diagnosis.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

namespace conddp {
namespace {

/// Rows of the log that are judged, and how many are needed to see a pattern.
constexpr int kWindow = 10;
constexpr int kFewest = 4;
/// What falls by less than this factor over the window stands still.
constexpr double kStandstill = 0.5;

/// The end of a log: the rows of the last steps, and the row before them.
class Window {
 public:
  explicit Window(const std::vector<IterationRecord>& log)
      : log_(log), steps_(std::clamp(static_cast<int>(log.size()) - 1, 0, kWindow)) {}

  int steps() const { return steps_; }
  const IterationRecord& first() const { return log_[log_.size() - 1 - steps_]; }
  const IterationRecord& last() const { return log_.back(); }

  /// How many of the steps have a property.
  template <class Property>
  int count(Property property) const {
    return static_cast<int>(std::count_if(log_.end() - steps_, log_.end(), property));
  }
  /// Whether a quantity ends at more than half of what it was at the start of the window. One good
  /// row between bad ones is no progress.
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

/// Whether the log is that of an interior-point method, whose steps follow a barrier and no
/// penalty.
bool interior_point(const SolveResult& r) {
  return std::any_of(r.log.begin(), r.log.end(),
                     [](const IterationRecord& row) { return row.barrier > 0; });
}

std::string at(int knot) { return knot < 0 ? std::string() : fmt::format(" at knot {}", knot); }

Diagnosis growth(const SolveResult& r) {
  const bool start = r.log.size() <= 1;
  return {
      DiagnosisPattern::growth,
      fmt::format("the {}{} {}", r.failed_quantity, at(r.failed_knot),
                  r.status == SolveStatus::diverged
                      ? (start ? "is not finite along the first guess" : "stopped being finite")
                      : "leaves the finite numbers in every longer step"),
      r.failed_knot, r.failed_quantity,
      std::string(start ? "another first guess (small controls, quasi_static, states near what is "
                          "possible), "
                        : "") +
          "a smaller dt or an integrator of higher order, smaller gains kp and kd of contacts; "
          "look for tiny masses and inertias ('conddp inspect')"};
}

Diagnosis indefinite(const SolveResult& r) {
  return {DiagnosisPattern::indefinite,
          fmt::format("{} stays indefinite{} with the largest regularisation", r.failed_quantity,
                      at(r.failed_knot)),
          r.failed_knot, r.failed_quantity,
          "a cost on every control of that knot; solver.regularization.kind: control; a larger "
          "solver.regularization.max"};
}

Diagnosis infeasible(const IterationRecord& last) {
  return {
      DiagnosisPattern::infeasible,
      fmt::format("the constraints cannot all be kept: violation {:.1e}{}, and no step that "
                  "lowers it",
                  last.constraint, at(last.constraint_knot)),
      last.constraint_knot, "constraint violation",
      "wider bounds, more time for the motion, or without a constraint (--drop) to see what the "
      "others ask for; a minimum of the violation can also be a local one: another first guess"};
}

Diagnosis rounding_floor(const SolveResult& r, const IterationRecord& last) {
  return {DiagnosisPattern::rounding_floor,
          fmt::format("rounding of the cost hides what is left to gain; stationarity ends at "
                      "{:.1e}{}",
                      r.residuals.stationarity, at(last.stationarity_knot)),
          last.stationarity_knot, "stationarity",
          "a larger solver.tolerances.stationarity (the answer is as good as the cost's digits "
          "allow), or smaller weights of costs that stay large"};
}

Diagnosis open_gaps(const Window& w) {
  return {
      DiagnosisPattern::open_gaps,
      fmt::format("the gaps stay open: {:.1e}{}, {}", w.last().gap, at(w.last().gap_knot),
                  w.steps() == 0 ? std::string("and no step lowers the merit")
                                 : fmt::format("after {:.1e} {} steps before (median step {:.2g})",
                                               w.first().gap, w.steps(), w.median_step())),
      w.last().gap_knot, "gap",
      "a larger solver.line_search.merit_margin, which weighs gaps more; states of the first "
      "guess that the controls can follow; more knots where the motion is fast"};
}

Diagnosis slow_feasibility(const Window& w) {
  return {DiagnosisPattern::slow_feasibility,
          fmt::format("full steps, but the violation falls slowly: {:.1e}{} after {:.1e} {} steps "
                      "before",
                      w.last().constraint, at(w.last().constraint_knot), w.first().constraint,
                      w.steps()),
          w.last().constraint_knot, "constraint violation",
          "a larger penalty to begin with, or one that grows faster"};
}

Diagnosis alternating(const Window& w) {
  const int changing = w.count([](const IterationRecord& r) { return r.active_set_changes > 0; });
  return {DiagnosisPattern::alternating_active_set,
          fmt::format("controls come to their bounds and leave them in {} of the last {} steps "
                      "({} changes in the last one), stationarity {:.1e}{}",
                      changing, w.steps(), w.last().active_set_changes, w.last().stationarity,
                      at(w.last().stationarity_knot)),
          w.last().stationarity_knot, "active set of the control bounds",
          "a larger weight on the control (bounds are degenerate where the cost hardly depends on "
          "it), or a larger solver.box_qp.horizon_sweeps"};
}

Diagnosis plateau(const Window& w, bool regularised) {
  std::string message = fmt::format(
      "stationarity stands still: {:.1e}{} after {:.1e} {} steps before, with {}",
      w.last().stationarity, at(w.last().stationarity_knot), w.first().stationarity, w.steps(),
      regularised ? fmt::format("regularisation {:.1e}", w.last().regularization)
                  : fmt::format("steps of {:.2g}", w.median_step()));
  return {DiagnosisPattern::plateau, std::move(message), w.last().stationarity_knot, "stationarity",
          regularised ? "a smaller solver.regularization.min or .initial; solver.regularization."
                        "decrease_step below the steps that are taken"
                      : "exact Hessians (solver.hessian: exact), a first guess nearer to the "
                        "answer, smoother costs (smooth_l1 with a larger epsilon)"};
}

Diagnosis no_descent(const SolveResult& r, const IterationRecord& last) {
  return {DiagnosisPattern::no_descent,
          fmt::format("no step lowers the merit; stationarity {:.1e}{}", last.stationarity,
                      at(last.stationarity_knot)),
          last.stationarity_knot, "merit",
          interior_point(r)
              ? "derivatives ('conddp check --derivatives'), costs and constraints that are not "
                "smooth, a first guess nearer to what is possible, solver.options: {mu_strategy: "
                "adaptive}"
          : r.residuals.gap > 0
              ? "derivatives ('conddp check --derivatives'), costs that are not smooth, a first "
                "guess with smaller gaps"
              : "derivatives ('conddp check --derivatives'), costs that are not smooth, a smaller "
                "solver.line_search.min_step"};
}

Diagnosis unfinished(const SolveResult& r, const SolverOptions& options,
                     const IterationRecord& last) {
  const auto& t = options.tolerances;
  std::string message =
      fmt::format("the solve stopped ({}) after {} iterations", to_string(r.status), r.iterations);
  Diagnosis d{
      DiagnosisPattern::unfinished, "", last.stationarity_knot, "stationarity",
      "more iterations or time (solver.max_iterations, --max-time), or go on from here with "
      "--warm-start"};
  if (last.gap > t.gap) {
    d.knot = last.gap_knot;
    d.quantity = "gap";
  }
  d.message = fmt::format(
      "{} while it made progress: stationarity {:.1e}, gap {:.1e}, violation "
      "{:.1e}",
      message, last.stationarity, last.gap, last.constraint);
  return d;
}

bool lost(const SolveResult& r) {
  if (r.status == SolveStatus::diverged || r.log.empty()) return true;
  const IterationRecord& last = r.log.back();
  return !std::isfinite(last.cost) || !std::isfinite(last.stationarity) || !std::isfinite(last.gap);
}

}  // namespace

std::string_view to_string(DiagnosisPattern pattern) {
  switch (pattern) {
    case DiagnosisPattern::normal:
      return "normal";
    case DiagnosisPattern::growth:
      return "growth";
    case DiagnosisPattern::indefinite:
      return "indefinite";
    case DiagnosisPattern::infeasible:
      return "infeasible";
    case DiagnosisPattern::rounding_floor:
      return "rounding_floor";
    case DiagnosisPattern::open_gaps:
      return "open_gaps";
    case DiagnosisPattern::slow_feasibility:
      return "slow_feasibility";
    case DiagnosisPattern::alternating_active_set:
      return "alternating_active_set";
    case DiagnosisPattern::plateau:
      return "plateau";
    case DiagnosisPattern::no_descent:
      return "no_descent";
    case DiagnosisPattern::unfinished:
      break;
  }
  return "unfinished";
}

Diagnosis diagnose(const SolveResult& result, const SolverOptions& options) {
  if (result.status == SolveStatus::converged)
    return {DiagnosisPattern::normal,
            fmt::format("normal convergence in {} iterations", result.iterations), -1, "", ""};
  if (lost(result)) return growth(result);
  if (result.status == SolveStatus::infeasible) return infeasible(result.log.back());
  if (interior_point(result)) {
    return result.status == SolveStatus::line_search_failed ||
                   result.status == SolveStatus::regularization_limit
               ? no_descent(result, result.log.back())
               : unfinished(result, options, result.log.back());
  }
  if (result.status == SolveStatus::regularization_limit) return indefinite(result);
  const Window w(result.log);
  const IterationRecord& last = w.last();
  const auto& t = options.tolerances;
  if (result.failed_quantity == kRoundedCost) return rounding_floor(result, last);
  const bool stuck = result.status == SolveStatus::line_search_failed && result.failed_knot < 0;
  if (last.gap > t.gap &&
      (stuck || (w.steps() >= kFewest && w.stands_still(&IterationRecord::gap))))
    return open_gaps(w);
  if (w.steps() >= kFewest) {
    const int full = w.count([](const IterationRecord& r) { return r.step >= 1; });
    if (last.constraint > t.constraint && full == w.steps() &&
        last.constraint > std::pow(kStandstill, w.steps()) * w.first().constraint)
      return slow_feasibility(w);
    if (last.stationarity > t.stationarity && w.stands_still(&IterationRecord::stationarity)) {
      const int changing =
          w.count([](const IterationRecord& r) { return r.active_set_changes > 0; });
      if (5 * changing >= 4 * w.steps()) return alternating(w);
      const int regularised = w.count([&](const IterationRecord& r) {
        return r.regularization > 0 && r.regularization >= options.regularization.min;
      });
      const bool small_steps = w.median_step() <= 0.25;
      if (small_steps || regularised == w.steps()) return plateau(w, regularised == w.steps());
    }
  }
  if (result.status == SolveStatus::line_search_failed)
    return result.failed_knot >= 0 ? growth(result) : no_descent(result, last);
  return unfinished(result, options, last);
}

}  // namespace conddp
