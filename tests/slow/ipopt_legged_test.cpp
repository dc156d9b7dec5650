// Legged ready problems by direct transcription, from the guesses of the DDP family.
#include <set>

#include "support/transcribed_problem.hpp"

namespace conddp {
namespace {

/// From their guesses these are not done within the iterations that are allowed.
const std::set<std::string> kFromAnswer = {"quadruped_ice", "quadruped_trot_cones"};

class TranscribedLegs : public ::testing::TestWithParam<std::string> {};

TEST_P(TranscribedLegs, HaveTheDerivativesOfTheirDifferences) {
  testing::check_transcription(GetParam());
}

TEST_P(TranscribedLegs, HaveTheKnownOptimum) {
  testing::expect_known_optimum(GetParam(), kFromAnswer.contains(GetParam()));
}

INSTANTIATE_TEST_SUITE_P(Ready, TranscribedLegs, ::testing::ValuesIn(testing::ready_problems(true)),
                         [](const auto& name) { return name.param; });

}  // namespace
}  // namespace conddp
