// Ready problems that take long, against their known answers.
#include "support/known_answer.hpp"

#include "support/transcribed_problem.hpp"

namespace conddp {
namespace {

std::vector<std::filesystem::path> answers() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(testing::slow_answers()))
    files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

class SlowAnswer : public ::testing::TestWithParam<std::filesystem::path> {};

TEST_P(SlowAnswer, IsFoundAgain) { testing::expect_known_answer(GetParam()); }

INSTANTIATE_TEST_SUITE_P(Golden, SlowAnswer, ::testing::ValuesIn(answers()),
                         [](const auto& file) { return file.param.stem().string(); });

}  // namespace
}  // namespace conddp
