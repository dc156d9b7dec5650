#include <gtest/gtest.h>

#include "problem_text.hpp"
#include "solvers/strategies/registry.hpp"
#include "systems/system.hpp"

namespace conddp {
namespace {

/// A hopper in the x-z plane whose foot is held in one direction.
std::string planar_hopper(const std::string& normal) {
  return fmt::format(R"(conddp: 1
robot: {{urdf: robots/hopper.urdf, base: planar, placement: {{rpy: [1.5707963267948966, 0, 0]}}}}
contacts: {{foot: {{frame: foot, type: normal, normal: {}}}}}
initial_state: {{base: {{position: [-0.023, 0.4583]}}, joints: {{hip: 0.75, knee: -1.4}}}}
phases: [{{knots: 3, dt: 0.02, contacts: all}}]
costs: {{effort: {{residual: control}}, calm: {{residual: joint_velocity}}}}
)",
                     normal);
}

ContactRank rank_at_start(const ShootingProblem& problem) {
  return problem.knot(0).model->system().contact_rank(problem.initial_state().data());
}

TEST(ContactRank, CountsRowsOfMovableDirections) {
  const Loaded loaded(planar_hopper("[0, 0, 1]"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ContactRank found = rank_at_start(*loaded.built->problem);
  EXPECT_EQ(found.rows, 1);
  EXPECT_EQ(found.rank, 1);
}

TEST(ContactRank, ContactAcrossThePlaneHasRankZero) {
  const Loaded loaded(planar_hopper("[0, 1, 0]"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  const ContactRank found = rank_at_start(problem);
  EXPECT_EQ(found.rows, 0);
  EXPECT_EQ(found.rank, 0);
  EXPECT_TRUE(found.redundant.empty());
  EXPECT_EQ(solve(problem, "box_fddp", {}, loaded.built->guess).status, SolveStatus::converged);
}

}  // namespace
}  // namespace conddp
