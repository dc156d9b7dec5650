// Motions that find their own contacts, beside what mechanics says of them.
#include "robot/kinematics.hpp"
#include "support/transcribed_problem.hpp"

namespace conddp {
namespace {

using testing::ReadyProblem;

constexpr double kMinForm = 1e-6;

SolveResult solve_ready(const ReadyProblem& ready) {
  return solve(*ready.built.problem, "ipopt", ready.spec.solver.options, ready.built.guess);
}

/// Largest |min(z, s)| of all pairs, and largest penetration at the knots, measured on the robot.
void expect_exact_contacts(const ReadyProblem& ready, const SolveResult& result) {
  EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
  const SteppingSystem& system = *ready.built.plant.stepping;
  RobotData<double> data(system.multibody().robot());
  for (int k = 0; k < result.trajectory.knots(); ++k) {
    for (const auto& [z, s] : system.layout().pairs)
      EXPECT_LE(std::abs(std::min(result.trajectory.u(k)[z], result.trajectory.u(k)[s])), kMinForm)
          << system.layout().columns[z].name << " at knot " << k;
    update_placements(system.multibody().robot(), result.trajectory.x(k + 1).data(), data);
    for (const CandidateGeometry& geometry : system.geometry()) {
      auto rows = geometry.create_rows<double>();
      geometry.evaluate(data, rows);
      EXPECT_GE(rows.gap, -kMinForm) << "knot " << k + 1;
    }
  }
}

double last(const SolveResult& result, int coordinate) {
  return result.trajectory.x(result.trajectory.knots())[coordinate];
}

TEST(BlockOnASlope, StaysUnderAForceBelowTheLimit) {
  const ReadyProblem ready("block_slope", {"constraints.force.upper=1.7"});
  const SolveResult result = solve_ready(ready);
  expect_exact_contacts(ready, result);
  EXPECT_NEAR(last(result, 0), 0, 1e-5);
}

TEST(BlockOnASlope, SlidesUnderAForceAboveTheLimit) {
  const double weight = 9.81, slope = 0.3, friction = 0.5, push = 2.5;
  const ReadyProblem ready("block_slope");
  const SolveResult result = solve_ready(ready);
  expect_exact_contacts(ready, result);
  // Steps of implicit Euler at constant acceleration: h² a N (N + 1)/2.
  const double a = push + weight * (std::sin(slope) - friction * std::cos(slope));
  EXPECT_GT(a, 0);
  EXPECT_NEAR(last(result, 0), 0.02 * 0.02 * a * 50 * 51 / 2, 1e-3);
}

TEST(BlockOnASlope, TheInnerProductFindsTheSame) {
  const ReadyProblem ready("block_slope", {"solver.complementarity.relaxation=inner_product",
                                           "solver.complementarity.fallback=none"});
  const SolveResult result = solve_ready(ready);
  expect_exact_contacts(ready, result);
  EXPECT_NEAR(result.cost, solve_ready(ReadyProblem("block_slope")).cost, 1e-5);
}

TEST(BlockOnASlope, RestartsGiveTheSameAnswerEveryTimeAndNoneThatIsWorse) {
  const std::vector<std::string> settings = {"solver.restarts.count=1", "solver.restarts.seed=3",
                                             "solver.restarts.spread=0.01"};
  const SolveResult first = solve_ready(ReadyProblem("block_slope", settings));
  const SolveResult second = solve_ready(ReadyProblem("block_slope", settings));
  EXPECT_EQ(first.status, SolveStatus::converged) << first.message;
  EXPECT_EQ(first.cost, second.cost);
  EXPECT_LE(first.cost, solve_ready(ReadyProblem("block_slope")).cost + 1e-9);
}

TEST(ContactsThatAreFound, AreRefusedByAllSolversButIpopt) {
  const ReadyProblem ready("block_slope");
  for (const SolverInfo& solver : solvers()) {
    const auto reason = refuse(solver, *ready.built.problem);
    if (solver.name == "ipopt") {
      EXPECT_FALSE(reason) << *reason;
      continue;
    }
    ASSERT_TRUE(reason) << solver.name;
    EXPECT_EQ(reason->find(std::string(solver.name) + " cannot keep the"), 0u) << *reason;
    EXPECT_NE(reason->find("ipopt"), std::string::npos) << *reason;
  }
}

}  // namespace
}  // namespace conddp
