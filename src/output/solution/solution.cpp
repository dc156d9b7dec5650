#include "output/solution/solution.hpp"

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

/// True if the pattern names what is wrong with the problem, whatever its steps are.
bool is_defect_of_problem(DiagnosisPattern pattern) {
  return pattern == DiagnosisPattern::no_static_equilibrium ||
         pattern == DiagnosisPattern::redundant_contacts ||
         pattern == DiagnosisPattern::free_control;
}

/// Recommends `auto` if the file's own solver is stuck and `auto` would try others.
Diagnosis diagnosis_of(const BuiltProblem& built, const SolveResult& result) {
  const SolverSpec& solver = built.facts().solver;
  Diagnosis d = diagnose(*built.problem, result, solver.options);
  const std::string& own = solver.name.value;
  if (!is_stuck(d.pattern) || own == kAutoSolver) return d;
  const auto others = auto_solvers(*built.problem, solver.options);
  if (std::ranges::any_of(others, [&](const SolverInfo* other) { return other->name != own; }))
    d.remedy += "; --solver auto, which tries several";
  return d;
}

}  // namespace

Answer::Answer(const BuiltProblem& built, const SolveResult& result)
    : values(*built.problem, result.trajectory),
      costs(cost_by_name(*built.problem, values)),
      violations(violations_by_name(*built.problem, result.constraint_values)),
      soft_violations(
          conddp::soft_violations(*built.problem, result.trajectory, result.constraint_values)),
      diagnosis(diagnosis_of(built, result)),
      findings(findings_of(built, result.trajectory, result.feedback.K, values)),
      forces(contact_forces(built, values)) {
  // Advice from the log does not help while steps are unstable; a defect of the problem comes
  // first.
  for (const Finding& finding : findings)
    if (finding.kind == FindingKind::unstable_steps && !is_success(result.status) &&
        !is_defect_of_problem(diagnosis.pattern))
      diagnosis.remedy = finding.remedy;
  for (const DroppedConstraint& constraint : built.dropped)
    dropped.emplace_back(constraint.name, violation(constraint, *built.problem, result.trajectory));
}

}  // namespace conddp
