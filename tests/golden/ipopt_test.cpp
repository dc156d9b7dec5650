// Ready problems by direct transcription: derivatives, and optima beside the known answers.
#include <set>

#include "support/transcribed_problem.hpp"

namespace conddp {
namespace {

/// From their guesses these lead to another local optimum than the DDP family finds.
const std::set<std::string> kOtherOptimum = {"arm_maze",        "car_parking",
                                             "pendulum_cycle",  "quadrotor_maze",
                                             "unicycle_escape", "unicycle_obstacles"};

class Transcribed : public ::testing::TestWithParam<std::string> {};

class TranscribedDerivatives : public ::testing::TestWithParam<std::string> {};

TEST_P(TranscribedDerivatives, AreThoseOfDifferences) { testing::check_transcription(GetParam()); }

TEST_P(Transcribed, HasTheKnownOptimum) {
  testing::expect_known_optimum(GetParam(), kOtherOptimum.count(GetParam()) > 0);
}

INSTANTIATE_TEST_SUITE_P(Ready, Transcribed, ::testing::ValuesIn(testing::ready_problems(false)),
                         testing::name_of);
INSTANTIATE_TEST_SUITE_P(Ready, TranscribedDerivatives,
                         ::testing::ValuesIn(testing::ready_problems(false)), testing::name_of);
INSTANTIATE_TEST_SUITE_P(Slow, TranscribedDerivatives,
                         ::testing::ValuesIn(testing::slow_problems()), testing::name_of);

}  // namespace
}  // namespace conddp
