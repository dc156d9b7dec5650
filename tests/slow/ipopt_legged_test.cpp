// Legged example problems by direct transcription, from the guesses of the DDP family.
#include "support/transcribed_problem.hpp"

namespace conddp {
namespace {

class TranscribedLegs : public ::testing::TestWithParam<std::string> {};

TEST_P(TranscribedLegs, DerivativesMatchDifferences) { testing::check_transcription(GetParam()); }

TEST_P(TranscribedLegs, HaveTheKnownOptimum) { testing::expect_known_optimum(GetParam(), false); }

INSTANTIATE_TEST_SUITE_P(Ready, TranscribedLegs,
                         ::testing::ValuesIn(testing::without("ipddp",
                                                              testing::ready_problems(true))),
                         [](const auto& name) { return name.param; });

}  // namespace
}  // namespace conddp
