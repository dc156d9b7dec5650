#include "output/solution/answer.hpp"

#include "output/solution/finding_report.hpp"

namespace conddp {

Answer::Answer(const ProblemSpec& spec, const BuiltProblem& built, const SolveResult& result)
    : values(*built.problem, result.trajectory),
      costs(cost_by_name(*built.problem, values)),
      violations(violations_by_name(*built.problem, result.constraint_values)),
      soft_violations(
          conddp::soft_violations(*built.problem, result.trajectory, result.constraint_values)),
      diagnosis(diagnose(*built.problem, result, spec.solver.options)),
      findings(findings_of(spec, built, result.trajectory, result.feedback.K, values)),
      forces(contact_forces(spec, *built.problem, values)) {
  for (const DroppedConstraint& constraint : built.dropped)
    dropped.emplace_back(constraint.name, violation(constraint, *built.problem, result.trajectory));
}

}  // namespace conddp
