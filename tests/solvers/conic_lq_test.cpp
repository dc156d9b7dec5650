#include <gtest/gtest.h>

#include "support/conic_optimality.hpp"

// Random conic problems of intermediate size; tests/slow covers full size.

namespace conddp::testing {
namespace {

TEST(ConicLinearQuadratic, SolversAgreeWithEachOtherAndWithIpopt) {
  for (const double slack : {0.3, 3.0, 20.0}) {
    ConicSize size = middle_size();
    size.slack = slack;
    for (const unsigned seed : {1u, 2u}) {
      expect_agreement(ConicLinearQuadratic(seed, size), {"altro", "proxddp", "ipddp", "ipopt"});
    }
  }
}

TEST(ConicLinearQuadratic, FewIterationsSufficeForAlternatingSets) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const ConicLinearQuadratic conic(seed, alternating_size());
    for (const SolveResult& result : expect_agreement(conic, {"altro", "proxddp"}))
      EXPECT_LE(result.iterations, 60) << seed;
  }
}

TEST(ConicLinearQuadratic, IntroSolvesEqualitiesToo) {
  const ConicSize size = equality_size();
  for (const unsigned seed : {1u, 2u}) {
    const auto results =
        expect_agreement(ConicLinearQuadratic(seed, size), {"intro", "altro", "proxddp"});
    EXPECT_EQ(results[0].iterations, 1);
  }
}

// Every constraint three times: multipliers are ambiguous, controls are not.
TEST(ConicLinearQuadratic, DuplicateConstraintsDoNoHarm) {
  ConicSize size = middle_size();
  size.slack = 3;
  for (const unsigned seed : {1u, 2u}) {
    const auto once = expect_agreement(ConicLinearQuadratic(seed, size), {"altro"});
    size.copies = 3;
    for (const SolveResult& result :
         expect_agreement(ConicLinearQuadratic(seed, size), {"altro", "proxddp"}))
      EXPECT_LT(control_distance(result, once[0]), 1e-7) << seed;
    size.copies = 1;
  }
}

// The known point is on the boundary of every box and at the tip of every cone.
TEST(ConicLinearQuadratic, SetsWithoutInteriorAreSolvedOrNamed) {
  ConicSize size = middle_size();
  size.slack = 0;
  for (const unsigned seed : {1u, 2u}) {
    const ConicLinearQuadratic conic(seed, size);
    for (const char* solver : {"altro", "proxddp"}) expect_answer(conic, solver);
  }
}

TEST(ConicLinearQuadratic, NamesContradictions) {
  ConicSize size = middle_size();
  size.contradictions = 1;
  const ConicLinearQuadratic conic(1, size);
  for (const char* solver : {"altro", "proxddp"}) {
    const SolveResult result = solve_strictly(conic, solver);
    EXPECT_EQ(result.status, SolveStatus::infeasible) << solver << ": " << result.message;
  }
}

}  // namespace
}  // namespace conddp::testing
