// Systems with non-finite values or derivatives at the first guess.
#include "analysis/findings/diagnosis.hpp"
#include "problem_text.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

constexpr std::string_view kNorm = R"(conddp: 1
system: {states: [x, y], controls: [u, w], rate: {x: u, y: w}}
initial_state: {}
phases: [{name: only, knots: 10, duration: 1}]
costs: {effort: {residual: control}, length: {residual: expression, rows: 'norm([x, y])'}}
terminal: {constraints: {end: {residual: state, reference: [2, 2]}}}
)";

SolveResult answer_at_kink(const Loaded& loaded, std::string_view solver) {
  return solve(*loaded.built->problem, solver, loaded.spec->solver.options, loaded.built->guess);
}

TEST(NotFinite, IpoptAnswerAgreesWithItsLog) {
  const Loaded loaded{std::string(kNorm)};
  ASSERT_TRUE(loaded.built) << loaded.all();
  const SolveResult result = answer_at_kink(loaded, "ipopt");
  EXPECT_EQ(result.status, SolveStatus::diverged) << result.message;
  ASSERT_FALSE(result.log.empty());
  EXPECT_EQ(result.cost, result.log.back().cost);
  EXPECT_EQ(result.residuals.gap, result.log.back().gap);
  EXPECT_EQ(result.residuals.constraint, 2);
}

TEST(NotFinite, AdviceFitsEquations) {
  const Loaded loaded{std::string(kNorm)};
  ASSERT_TRUE(loaded.built) << loaded.all();
  for (const char* solver : {"altro", "ipopt"}) {
    const Diagnosis d = diagnose(*loaded.built->problem, answer_at_kink(loaded, solver),
                                 loaded.spec->solver.options);
    EXPECT_EQ(d.pattern, DiagnosisPattern::growth) << solver;
    EXPECT_NE(d.message.find("is not finite along the first guess"), std::string::npos)
        << d.message;
    EXPECT_NE(d.remedy.find("smooth_norm"), std::string::npos) << d.remedy;
    EXPECT_EQ(d.remedy.find("kp"), std::string::npos) << d.remedy;
  }
}

TEST(NotFinite, NamesANonFiniteCost) {
  const Loaded loaded(R"(conddp: 1
system: {states: [x], controls: [u], rate: {x: u}}
initial_state: {values: {x: 0}}
phases: [{knots: 5, dt: 0.1}]
costs: {effort: {residual: control}, bad: {residual: expression, rows: log(x)}}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const Diagnosis d = diagnose(*loaded.built->problem, answer_at_kink(loaded, "box_fddp"),
                               loaded.spec->solver.options);
  EXPECT_NE(d.message.find("cost"), std::string::npos) << d.message;
  EXPECT_NE(d.message.find("('bad')"), std::string::npos) << d.message;
}

TEST(NotFinite, NamesDynamicsBeforeDependentCosts) {
  const Loaded loaded(R"(conddp: 1
system: {states: [x, y], controls: [a], rate: {x: sqrt(y)*cos(a), y: sqrt(y)*sin(a)}}
initial_state: {}
phases: [{name: only, knots: 10, duration: 1}]
costs: {effort: {residual: control}}
terminal: {constraints: {end: {residual: state, reference: [2, 2]}}}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(answer_at_kink(loaded, "altro").failed_quantity, "dynamics Jacobian");
  EXPECT_EQ(answer_at_kink(loaded, "ipopt").failed_quantity, "dynamics Jacobian");
}

}  // namespace
}  // namespace conddp
