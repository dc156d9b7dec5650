#include "solvers/constraints/outer_strategy.hpp"

#include "solvers/common/feasible.hpp"

namespace conddp {

void OuterStrategy::measure(const Iterate& iterate, IterationRecord& row) {
  const Extremum bounds = iterate.bounds.violation(iterate.trajectory);
  row.constraint = bounds.value;
  row.constraint_knot = bounds.knot;
}

bool OuterStrategy::solved(const IterationRecord& row, const SolverOptions::Tolerances& tolerances,
                           double stationarity) const {
  return row.stationarity <= stationarity && is_feasible(row, tolerances);
}

bool OuterStrategy::update(Iterate& /*iterate*/, const Feedback& /*feedback*/,
                           const MeritModel& /*merit*/, bool /*stuck*/, SolveRecord& /*record*/) {
  return true;
}

}  // namespace conddp
