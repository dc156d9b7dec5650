// Each residual alone in every possible role. Its requirements (previous control or initial state
// in the state, contact forces) must come with the residual, not with a cost that usually
// accompanies it.
#include <gtest/gtest.h>

#include "analysis/derivatives/derivative_check.hpp"
#include "problem_file/residuals/residual_table.hpp"
#include "problem_text.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

/// Required keys of residuals.
std::string keys(const ResidualDefinition& residual) {
  std::string keys;
  if (residual.has("frame")) keys += ", frame: lf_foot";
  if (residual.has("pairs")) keys += ", pairs: all";
  if (residual.name == "expression")
    keys += ", rows: [\"q[LF_KFE] + 0.5*v[LF_KFE]^2 + 0.02*sin(9*t)\", base.position.z - 0.57]";
  else if (residual.has("rows"))
    keys += ", rows: [{q/LF_KFE: 1, v/LF_KFE: 0.5, constant: 0.05}]";
  const ReferenceForm* form = residual.reference;
  if (form != nullptr && (form->needed != ReferenceForm::Needed::kNever || residual.of_positions))
    keys += ", reference: initial";
  return keys;
}

enum class Role { kCost, kHard, kL1, kL2, kNorm, kOneKnot, kTerminalCost, kTerminal };
constexpr Role kRoles[] = {Role::kCost, Role::kHard,    Role::kL1,           Role::kL2,
                           Role::kNorm, Role::kOneKnot, Role::kTerminalCost, Role::kTerminal};

bool of_the_last_node(Role role) { return role == Role::kTerminalCost || role == Role::kTerminal; }

/// A quadruped on one foot (a sole if the residual requires it) with only the residual.
std::string problem_with(const ResidualDefinition& residual, Role role) {
  const bool sole = residual.name == "wrench_cone" || residual.name == "center_of_pressure";
  std::string text = fmt::format(
      R"(conddp: 1
robot: {{urdf: robots/quadruped.urdf, base: floating}}
contacts:
  LF: {{frame: lf_foot, friction: 0.5{}}}
initial_state: {{base: {{position: [0, 0, 0.57]}}}}
collision:
  shapes: {{foot: {{frame: lf_foot, sphere: {{radius: 0.02}}}}}}
  obstacles: {{floor: {{half_space: {{normal: [0, 0, 1], point: [0, 0, -0.3]}}}}}}
phases:
)",
      sole ? ", type: surface, size: [0.2, 0.1]" : "");
  if (residual.needs.chosen_start) text += "  - {choose: all}\n";
  text += "  - {name: stand, knots: 4, dt: 0.02, contacts: all}\n";
  const std::string own = fmt::format("residual: {}", residual.name) + keys(residual);
  const bool bounded = residual.is_cone;
  const bool distance = residual.needs.shapes;
  std::string cost, constraint;
  switch (role) {
    case Role::kCost:
    case Role::kTerminalCost:
      cost = own;
      break;
    case Role::kNorm:
      constraint = own + ", at_most: 5";
      break;
    default:
      constraint = own;
      if (distance) constraint += ", lower: 0.01";
      if (!bounded && !distance) constraint += ", lower: -0.1, upper: 0.1";
  }
  if (role == Role::kL1) constraint += ", soft: l1, weight: 3";
  if (role == Role::kL2) constraint += ", soft: l2, weight: 3";
  if (role == Role::kOneKnot)
    constraint += residual.needs.chosen_start ? ", knots: [3]" : ", knots: [2]";
  const std::string block = cost.empty()
                                ? fmt::format("constraints: {{alone: {{{}}}}}\n", constraint)
                                : fmt::format("costs: {{alone: {{{}}}}}\n", cost);
  text += of_the_last_node(role) ? "terminal:\n  " + block : block;
  text += "solver: {name: altro}\n";
  return text;
}

TEST(EveryResidual, WorksAloneInEveryRole) {
  int tried = 0;
  for (const ResidualDefinition* residual : residual_table())
    for (const Role role : kRoles) {
      if (residual->name == "library") continue;  // of states without spatial rotations
      if (of_the_last_node(role) && !residual->at_last_node()) continue;
      if (role == Role::kNorm && (residual->is_cone || residual->needs.shapes)) continue;
      const std::string text = problem_with(*residual, role);
      SCOPED_TRACE(text);
      const Loaded loaded(text);
      ASSERT_TRUE(loaded.built) << loaded.all();
      const ShootingProblem& problem = *loaded.built->problem;
      for (const DerivativeComparison& derivative :
           check_derivatives(problem, loaded.built->guess, {.knots_per_phase = 2}))
        EXPECT_LT(derivative.error, 1e-6);
      SolverOptions options = loaded.spec->solver.options;
      options.max_iterations = 2;
      for (const char* name : {"altro", "proxddp", "ipopt"})
        EXPECT_EQ(solve(problem, name, options, loaded.built->guess).trajectory.knots(),
                  problem.knots());
      ++tried;
    }
  EXPECT_GT(tried, 120);
}

TEST(EveryResidual, ControlRateWorksWithoutItsCost) {
  const std::string text = R"(conddp: 1
system: {type: double_integrator, dimension: 1}
initial_state: {state: [0, 0]}
phases: [{name: only, knots: 20, dt: 0.1}]
costs: {effort: {residual: control, weight: 0.001}}
constraints: {rate: {residual: control_rate, lower: -0.1, upper: 0.1}}
terminal: {costs: {goal: {residual: state, reference: [1, 0], weight: 100}}}
solver: {name: altro}
)";
  const Loaded loaded(text);
  ASSERT_TRUE(loaded.built) << loaded.all();
  for (const char* name : {"altro", "proxddp", "ipopt"}) {
    const SolveResult result =
        solve(*loaded.built->problem, name, loaded.spec->solver.options, loaded.built->guess);
    EXPECT_EQ(result.status, SolveStatus::converged) << name;
    double previous = 0, fastest = 0;
    for (int k = 0; k < 20; ++k) {
      fastest = std::max(fastest, std::abs(result.trajectory.u(k)[0] - previous));
      previous = result.trajectory.u(k)[0];
    }
    EXPECT_NEAR(fastest, 0.1, 1e-6) << name;
  }
}

}  // namespace
}  // namespace conddp
