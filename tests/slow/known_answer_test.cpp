// Slow example problems, compared with their known answers.
#include "support/known_answer.hpp"

#include "output/report/certificate_report.hpp"
#include "support/transcribed_problem.hpp"

namespace conddp {
namespace {

class SlowAnswer : public ::testing::TestWithParam<std::string> {};

TEST_P(SlowAnswer, IsFoundAgainAndItsCertificateHolds) {
  const nlohmann::json answer =
      testing::expect_known_answer(testing::slow_answers() / (GetParam() + ".json"));
  const testing::ReadyProblem ready(GetParam());
  const SolutionCertificate certificate =
      certify_solution(OrderedJson::parse(answer.dump()), ready.built, false);
  EXPECT_TRUE(certificate.checks.holds()) << certificate_table(certificate.checks);
}

INSTANTIATE_TEST_SUITE_P(Golden, SlowAnswer, ::testing::ValuesIn(testing::slow_problems()),
                         [](const auto& name) { return name.param; });

}  // namespace
}  // namespace conddp
