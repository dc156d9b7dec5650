// A biped without ankle roll on two flat soles. Its legs cannot resist one force along the line
// through both hips. Hence 11 of the 12 contact rows are independent in every state that the soles
// allow, and all 12 nearby.
#include <gtest/gtest.h>

#include "analysis/derivatives/derivative_check.hpp"
#include "output/solution/finding_report.hpp"
#include "support/transcribed_problem.hpp"

namespace conddp {
namespace {

using testing::ReadyProblem;

/// A squat that shifts the weight sideways and so bends the legs out of their parallel planes.
ReadyProblem squat(const std::string& solver) {
  return ReadyProblem("biped_squat",
                      {"robot.locked_joints.l_ankle_roll=0", "robot.locked_joints.r_ankle_roll=0",
                       "costs.height.reference.values=[[0.03, 0, 0.744], [0.03, 0, 0.744], "
                       "[0.03, 0.05, 0.704], [0.03, 0.05, 0.704], [0.03, 0, 0.744], "
                       "[0.03, 0, 0.744]]",
                       "solver.name=" + solver});
}

TEST(RedundantContacts, BipedWithoutAnkleRollWorksWithEverySolver) {
  for (const char* name : {"box_fddp", "altro", "proxddp", "ipopt"}) {
    const ReadyProblem ready = squat(name);
    const SolverInfo& solver = *find_solver(name);
    const SolverOptions& options = ready.spec.solver.options;
    const SolveResult result = solve(*ready.built.problem, solver, options, ready.built.guess);
    EXPECT_EQ(result.status, SolveStatus::converged) << name << ": " << result.message;
    EXPECT_NEAR(result.cost, 5.770416, 1e-4) << name;
    const OrderedJson document =
        OrderedJson::parse(solution_json({ready.built, solver, result, {}}).dump());
    for (const Check& check : certify_solution(document, ready.built, false).checks.checks)
      EXPECT_TRUE(check.holds) << name << ": " << check.name << ' ' << check.message;
    bool named = false;
    for (const Finding& f : findings_of(ready.built, result.trajectory, result.feedback.K,
                                        NodeValues(*ready.built.problem, result.trajectory))) {
      EXPECT_NE(f.kind, FindingKind::drift) << name << ": " << f.message;
      named = named || f.kind == FindingKind::redundant_contacts;
    }
    EXPECT_TRUE(named) << name;
  }
}

TEST(RedundantContacts, DerivativesMatchDualNumbers) {
  const ReadyProblem ready = squat("box_fddp");
  const auto list = check_derivatives(*ready.built.problem, ready.built.guess);
  ASSERT_FALSE(list.empty());
  for (const DerivativeComparison& c : list)
    EXPECT_LT(c.error, 1e-9) << c.row << ", " << c.column << " at knot " << c.knot << ": "
                             << c.analytic << ", " << c.reference;
}

}  // namespace
}  // namespace conddp
