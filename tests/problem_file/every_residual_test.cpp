// Every residual alone in every role it can have: what a residual needs of a problem (a state that
// holds the previous control or the first state, forces of contacts) must come with it, not with
// the cost that usually accompanies it.
#include <gtest/gtest.h>

#include "analysis/certificate/derivative_check.hpp"
#include "problem_text.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

/// The residual with the keys that it cannot do without.
std::string keys(ResidualKind kind) {
  switch (kind) {
    case ResidualKind::kState:
      return "reference: initial";
    case ResidualKind::kFramePosition:
    case ResidualKind::kFrameRotation:
    case ResidualKind::kFramePlacement:
      return "frame: lf_foot, reference: initial";
    case ResidualKind::kFrameVelocity:
      return "frame: lf_foot";
    case ResidualKind::kComPosition:
      return "reference: initial";
    case ResidualKind::kDistance:
      return "pairs: all";
    case ResidualKind::kCombination:
      return "rows: [{q/LF_KFE: 1, v/LF_KFE: 0.5, constant: 0.05}]";
    default:
      return "";
  }
}

enum class Role { kCost, kHard, kL1, kL2, kNorm, kOneKnot, kTerminalCost, kTerminal };
constexpr Role kRoles[] = {Role::kCost, Role::kHard,    Role::kL1,           Role::kL2,
                           Role::kNorm, Role::kOneKnot, Role::kTerminalCost, Role::kTerminal};

bool of_the_last_node(Role role) { return role == Role::kTerminalCost || role == Role::kTerminal; }

/// A quadruped on one foot (a sole where the residual asks for one), and nothing but the residual.
std::string problem_with(const ResidualInfo& info, Role role) {
  const bool sole =
      info.kind == ResidualKind::kWrenchCone || info.kind == ResidualKind::kCenterOfPressure;
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
  if (info.kind == ResidualKind::kCycle) text += "  - {choose: all}\n";
  text += "  - {name: stand, knots: 4, dt: 0.02, contacts: all}\n";
  std::string own = fmt::format("residual: {}", info.name);
  if (const std::string more = keys(info.kind); !more.empty()) own += ", " + more;
  const bool bounded = info.is_cone;
  const bool distance = info.of_shapes;
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
    constraint += info.kind == ResidualKind::kCycle ? ", knots: [3]" : ", knots: [2]";
  const std::string block = cost.empty()
                                ? fmt::format("constraints: {{alone: {{{}}}}}\n", constraint)
                                : fmt::format("costs: {{alone: {{{}}}}}\n", cost);
  text += of_the_last_node(role) ? "terminal:\n  " + block : block;
  text += "solver: {name: altro}\n";
  return text;
}

TEST(EveryResidual, AloneInEveryRoleIsEvaluatedDifferentiatedAndSolvedFor) {
  int tried = 0;
  for (const ResidualInfo& info : residual_table())
    for (const Role role : kRoles) {
      if (of_the_last_node(role) && (info.needs_control || info.is_cone)) continue;
      if (of_the_last_node(role) && info.kind == ResidualKind::kContactForce) continue;
      if (role == Role::kNorm && (info.is_cone || info.of_shapes)) continue;
      const std::string text = problem_with(info, role);
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

TEST(EveryResidual, ControlRateHoldsWithoutACostOnIt) {
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
