#include "solvers/outer_strategy.hpp"

namespace conddp {

void OuterStrategy::measure(const Iterate& iterate, IterationRecord& row) {
  const Extremum bounds = iterate.bounds.violation(iterate.trajectory);
  row.constraint = bounds.value;
  row.constraint_knot = bounds.knot;
}

bool OuterStrategy::update(Iterate& /*iterate*/, const Feedback& /*feedback*/,
                           const MeritModel& /*merit*/, bool /*stuck*/, SolveRecord& /*record*/) {
  return true;
}

}  // namespace conddp
