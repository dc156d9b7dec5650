#include "output/report/answer_claims.hpp"

#include "analysis/certificate/certificate_doubt.hpp"
#include "output/solution/solution.hpp"

namespace conddp {

AnswerClaims answer_claims(const Solution& s) {
  const ShootingProblem& problem = *s.built.problem;
  AnswerClaims claims{
      .solution = claims_of(problem, s.result, s.answer.values, s.spec.solver.options),
      .iterations = s.result.iterations,
      .duration = problem.times(s.result.trajectory).back(),
      .constraint_values = s.result.constraint_values,
      .violations = s.answer.violations,
      .soft_violations = s.answer.soft_violations,
      .dropped = s.answer.dropped,
      .forces = s.answer.forces,
      .log = s.result.log};
  claims.solution.tangent_names = tangent_columns(s.built);
  for (auto* list : {&claims.violations, &claims.soft_violations})
    for (ConstraintViolation& v : *list) v.value = finite_or_open(v.value);
  for (auto& [name, value] : claims.dropped) value = finite_or_open(value);
  for (double& value : claims.constraint_values) value = finite_or_open(value);
  for (IterationRecord& row : claims.log)
    for (double* figure : {&row.cost, &row.gap, &row.constraint, &row.stationarity})
      *figure = finite_or_open(*figure);
  if (!s.mesh.empty())
    claims.grid_error = {finite_or_open(s.mesh.back().error), s.spec.mesh->error};
  return claims;
}

}  // namespace conddp
