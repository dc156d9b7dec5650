#include "solvers/constraints/newton_polish.hpp"

#include <algorithm>

namespace conddp {
namespace {

/// Largest violation, gap and stationarity for the first try; share of these that the next try
/// requires after a failure; maximum number of steps, and of damped steps.
constexpr double kFirstThreshold = 3e-3, kNextThreshold = 0.1;
constexpr int kSteps = 20, kDampedSteps = 2;
/// Norm below which nothing is left to gain.
constexpr double kGoal = 1e-12;

double largest_norm(const IterationRecord& row) {
  return std::max({row.stationarity, row.gap, row.constraint});
}

}  // namespace

NewtonPolish::NewtonPolish(const ShootingProblem& problem, Evaluator& evaluator,
                           const SolverOptions& options)
    : newton_(problem, evaluator), options_(options) {}

void NewtonPolish::reset() { threshold_ = kFirstThreshold; }

/// Takes steps until nothing is left to gain, or too many of them are damped.
void NewtonPolish::iterate_newton(SolveRecord& record) {
  IterationRecord& row = record.row;
  int damped = 0;
  for (int i = 0; i < kSteps && row.iteration < options_.max_iterations; ++i) {
    if (newton_.norms().largest() <= kGoal || !newton_.step()) return;
    ++row.iteration;
    ++row.newton;
    newton_.describe(row);
    record.log_row();
    record.log_is_stale = true;  // until the iterate is accepted
    damped += newton_.step_length() < 1;
    if (damped > kDampedSteps) return;
  }
}

bool NewtonPolish::due(const IterationRecord& row) const {
  return !(largest_norm(row) > threshold_);
}

bool NewtonPolish::run(Iterate& iterate, const Feedback& feedback, OuterStrategy& outer,
                       SolveRecord& record) {
  IterationRecord& row = record.row;
  const IterationRecord start = row;
  newton_.start(iterate.trajectory, *outer.multipliers(), outer.augmentation()->penalty, feedback);
  iterate_newton(record);
  threshold_ = kNextThreshold * largest_norm(start);
  const auto& tolerance = options_.tolerances;
  const KktNorms& norms = newton_.norms();
  // Without a step, Newton's multipliers are no better than the present ones.
  const bool stands =
      row.iteration == start.iteration && norms.complementarity > tolerance.complementarity;
  if (stands || norms.stationarity.value > tolerance.stationarity ||
      norms.gap.value > tolerance.gap || norms.violation.value > tolerance.constraint) {
    const int iteration = row.iteration, newton = row.newton;
    row = start;
    row.iteration = iteration;
    row.newton = newton;
    return false;
  }
  iterate.before = iterate.trajectory;
  iterate.trajectory = newton_.trajectory();
  iterate.linearized = iterate.differentiated = false;
  outer.adopt(newton_.multipliers());
  record.log_is_stale = false;
  return true;
}

}  // namespace conddp
