#include "output/solution/answer.hpp"

#include <algorithm>

#include "output/solution/finding_report.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

/// True if another solver may do better after such an end.
bool is_stuck(DiagnosisPattern pattern) {
  return pattern == DiagnosisPattern::plateau || pattern == DiagnosisPattern::no_descent ||
         pattern == DiagnosisPattern::undecided;
}

/// Recommends `auto` if the file's own solver is stuck and `auto` would try others.
Diagnosis diagnosis_of(const ProblemSpec& spec, const BuiltProblem& built,
                       const SolveResult& result) {
  Diagnosis d = diagnose(*built.problem, result, spec.solver.options);
  const std::string& own = spec.solver.name.value;
  if (!is_stuck(d.pattern) || own == kAutoSolver) return d;
  const auto others = auto_solvers(*built.problem, spec.solver.options);
  if (std::ranges::any_of(others, [&](const SolverInfo* solver) { return solver->name != own; }))
    d.remedy += "; --solver auto, which tries several";
  return d;
}

}  // namespace

Answer::Answer(const ProblemSpec& spec, const BuiltProblem& built, const SolveResult& result)
    : values(*built.problem, result.trajectory),
      costs(cost_by_name(*built.problem, values)),
      violations(violations_by_name(*built.problem, result.constraint_values)),
      soft_violations(
          conddp::soft_violations(*built.problem, result.trajectory, result.constraint_values)),
      diagnosis(diagnosis_of(spec, built, result)),
      findings(findings_of(spec, built, result.trajectory, result.feedback.K, values)),
      forces(contact_forces(spec, *built.problem, values)) {
  // Advice from the log does not help while steps are unstable.
  for (const Finding& finding : findings)
    if (finding.kind == FindingKind::unstable_steps && !is_success(result.status))
      diagnosis.remedy = finding.remedy;
  for (const DroppedConstraint& constraint : built.dropped)
    dropped.emplace_back(constraint.name, violation(constraint, *built.problem, result.trajectory));
}

}  // namespace conddp
