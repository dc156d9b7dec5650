// Random conic problems of full size: altro and proxddp find the optimum in few iterations, however
// narrow the bounds and unstable the dynamics.
#include <gtest/gtest.h>

#include "support/conic_optimality.hpp"

namespace conddp::testing {
namespace {

class LargeConicLinearQuadratic
    : public ::testing::TestWithParam<std::tuple<unsigned, double, double, double>> {};

TEST_P(LargeConicLinearQuadratic, SolversAgreeWithinFewIterations) {
  const auto [seed, spectral_radius, control, slack] = GetParam();
  ConicSize size = large_size();
  size.spectral_radius = spectral_radius;
  size.control = control;
  size.slack = slack;
  const ConicLinearQuadratic conic(seed, size);
  EXPECT_EQ(conic.problem->constraint_rows(), 2226);
  for (const SolveResult& result : expect_agreement(conic, {"altro", "proxddp"}))
    EXPECT_LE(result.iterations, 60);
}

INSTANTIATE_TEST_SUITE_P(Seeds, LargeConicLinearQuadratic,
                         ::testing::Combine(::testing::Values(1u, 2u, 3u),
                                            ::testing::Values(0.95, 1.0, 1.02),
                                            ::testing::Values(0.3, 1.0),
                                            ::testing::Values(0.3, 3.0)));

}  // namespace
}  // namespace conddp::testing
