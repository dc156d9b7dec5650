// Every case of tests/broken is rejected by the tool as a process.
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "broken_case.hpp"

namespace conddp {
namespace {

// Sanitizers reserve terabytes of addresses and slow the tests.
#ifdef __SANITIZE_ADDRESS__
constexpr ProcessLimits kLimits{.processor_s = 40};
#else
constexpr ProcessLimits kLimits{.processor_s = 2, .memory_bytes = 500'000'000};
#endif

/// True if each text begins an output line after its indentation, in order.
testing::AssertionResult says(const std::string& output, const std::vector<std::string>& lines) {
  std::size_t at = 0;
  for (const std::string& line : lines) {
    const auto begins_a_line = [&](std::size_t where) {
      while (where > 0 && output[where - 1] == ' ') --where;
      return where == 0 || output[where - 1] == '\n';
    };
    do {
      at = output.find(line, at);
      if (at == std::string::npos)
        return testing::AssertionFailure() << "no line begins with\n" << line << "\nin\n" << output;
    } while (!begins_a_line(at++));
  }
  return testing::AssertionSuccess();
}

void expect_refused(const BrokenCase& broken) {
  const TemporaryFolder folder;
  broken.prepare(folder);
  const std::vector<std::string> before = folder.files();
  const ProcessResult r =
      run_conddp(broken.arguments, {.folder = folder.path(), .limits = kLimits});
  EXPECT_EQ(r.exit_code, 2) << r.err;
  EXPECT_EQ(r.out, "");
  EXPECT_TRUE(says(r.err, broken.says));
  for (const std::string& text : broken.lacks)
    EXPECT_EQ(r.err.find(text), std::string::npos) << text << "\nin\n" << r.err;
  EXPECT_EQ(folder.files(), before);
}

class Broken : public testing::TestWithParam<std::string> {};

TEST_P(Broken, InputsAreRejectedWithTheirPlaces) {
  for (const BrokenCase& broken : broken_cases(GetParam())) {
    SCOPED_TRACE(GetParam() + ": " + broken.name);
    expect_refused(broken);
  }
}

INSTANTIATE_TEST_SUITE_P(Groups, Broken, testing::ValuesIn(broken_groups()),
                         [](const auto& test) { return test.param; });

TEST(BrokenInputs, UnmodifiedInputsAreGood) {
  const TemporaryFolder folder;
  write_good_inputs(folder);
  for (const std::string problem : {"pendulum", "tracking", "arm", "legs", "gait", "block"}) {
    const ProcessResult r =
        run_conddp({"solve", problem + ".yaml", "-o", "out"}, {.folder = folder.path()});
    EXPECT_EQ(r.exit_code, 0) << r.err;
    EXPECT_EQ(r.err, "");
  }
}

TEST(BrokenInputs, AreManyAndHaveNames) {
  std::size_t count = 0;
  for (const std::string& group : broken_groups()) {
    std::set<std::string> names;
    for (const BrokenCase& broken : broken_cases(group))
      EXPECT_TRUE(names.insert(broken.name).second) << group << ": " << broken.name << " twice";
    count += names.size();
  }
  EXPECT_GE(count, 120u);
}

}  // namespace
}  // namespace conddp
