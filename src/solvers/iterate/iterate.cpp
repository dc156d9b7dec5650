#include "solvers/iterate/iterate.hpp"

#include <limits>

#include <fmt/format.h>

#include "base/stopwatch.hpp"
#include "solvers/common/finite_check.hpp"

namespace conddp {

Iterate::Iterate(const ShootingProblem& problem, const ControlBounds& control_bounds,
                 Evaluator& shared_evaluator, const DdpRecipe& recipe, const SolverOptions& options,
                 SolveRecord& record)
    : bounds(control_bounds),
      evaluator(shared_evaluator),
      trajectory(problem.create_trajectory()),
      before(problem.create_trajectory()),
      linearization(problem),
      gaps(problem),
      adjoint(problem, control_bounds),
      hessian(recipe.hessian, options.tolerances.stationarity, shared_evaluator, linearization),
      exact_below(hessian.exact_alone() ? std::numeric_limits<double>::infinity()
                                        : options.tolerances.gap),
      record_(record),
      open_gaps_(recipe.open_gaps) {}

void Iterate::reset() {
  linearized = differentiated = false;
  hessian.reset();
}

void Iterate::differentiate(const Feedback& feedback, const Augmentation* augmentation) {
  const Stopwatch watch(times().differentiate);
  hessian.begin_iterate();
  if (!differentiated) evaluator.differentiate(trajectory, linearization, augmentation);
  differentiated = false;
  gaps.set(linearization, open_gaps_);
  adjoint.compute(linearization, trajectory, gaps, feedback);
  linearized = is_finite();
  const bool closed = !open_gaps_ || linearization.max_gap() <= exact_below;
  if (hessian.exact_wanted() && linearized && closed)
    hessian.evaluate_exact(trajectory, adjoint.costates(), augmentation);
}

/// Checks costs, gaps and co-states, which become non-finite with any other quantity.
bool Iterate::is_finite() const {
  return std::isfinite(linearization.total_cost()) &&
         std::isfinite(linearization.augmentation.sum()) && all_finite(linearization.gap) &&
         all_finite(adjoint.costates()) && all_finite(adjoint.gradient());
}

bool Iterate::end_diverged() {
  const NonFinite where = find_non_finite(linearization).value_or(NonFinite{0, "co-state"});
  const bool first = record_.row.iteration == 0;
  if (!first) {
    trajectory = before;
    record_.row.iteration = record_.result.log.back().iteration;  // the step does not count
  }
  linearized = false;
  record_.result.failed_knot = where.knot;
  record_.result.failed_quantity = where.quantity;
  return record_.end(SolveStatus::diverged,
                     fmt::format("the {} of knot {} is not finite {}", where.quantity, where.knot,
                                 first ? "at the start" : "after the last step, which is undone"));
}

Extremum Iterate::largest_gap() const {
  Extremum largest{linearization.max_gap(), -1};
  if (!(largest.value > 0)) return largest;
  Eigen::Index row = 0, column = 0;
  linearization.gap.cwiseAbs().maxCoeff(&row, &column);
  largest.knot = static_cast<int>(column);
  return largest;
}

void Iterate::describe(IterationRecord& row) const {
  const Extremum gradient = stationarity(), gap = largest_gap();
  row.stationarity = gradient.value;
  row.stationarity_knot = gradient.knot;
  row.gap = gap.value;
  row.gap_knot = gap.knot;
}

}  // namespace conddp
