#include "problem_file/spec/spec.hpp"

namespace conddp {

const CostSpec* ProblemSpec::first_use(bool ResidualNeeds::*need) const {
  for (const auto* list : {&costs, &terminal_costs})
    for (const CostSpec& cost : *list)
      if (cost.definition->needs.*need) return &cost;
  for (const auto* list : {&constraints, &terminal_constraints})
    for (const ConstraintSpec& constraint : *list)
      if (!constraint.bounded && constraint.function.definition->needs.*need)
        return &constraint.function;
  return nullptr;
}

const PhaseSpec* ProblemSpec::first_free_duration() const {
  for (const PhaseSpec& phase : phases)
    if (phase.free_duration) return &phase;
  return nullptr;
}

}  // namespace conddp
