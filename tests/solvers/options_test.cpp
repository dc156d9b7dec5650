#include "solvers/common/options.hpp"

#include <set>

#include <gtest/gtest.h>

#include "solvers/common/option_table.hpp"

namespace conddp {
namespace {

TEST(SolverOptions, DefaultsAreValid) { EXPECT_TRUE(SolverOptions().validate().empty()); }

TEST(SolverOptions, NamesEveryBadValueAndReplacesNothing) {
  SolverOptions options;
  options.tolerances.gap = -1;
  options.augmented_lagrangian.penalty_factor = 1;
  options.complementarity.initial = std::numeric_limits<double>::quiet_NaN();
  const auto messages = options.validate();
  ASSERT_EQ(messages.size(), 3u);
  EXPECT_NE(messages[0].find("tolerances.gap"), std::string::npos);
  EXPECT_NE(messages[1].find("augmented_lagrangian.penalty_factor"), std::string::npos);
  EXPECT_NE(messages[2].find("complementarity.initial"), std::string::npos);
  EXPECT_EQ(options.tolerances.gap, -1);
}

TEST(SolverOptions, NamesContradictoryOptions) {
  SolverOptions options;
  options.augmented_lagrangian.initial_penalty = 2;
  options.augmented_lagrangian.max_penalty = 1;
  const auto messages = options.validate();
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_NE(messages[0].find("augmented_lagrangian.initial_penalty"), std::string::npos);
}

TEST(OptionTable, ReadsAndWritesEveryOption) {
  std::set<std::string_view> names;
  for (const OptionInfo& info : option_table()) {
    EXPECT_TRUE(names.insert(info.name).second) << info.name;
    EXPECT_FALSE(info.doc.empty());
    EXPECT_EQ(info.doc.back(), '.');
    EXPECT_EQ(find_option(info.name), &info);
    SolverOptions options;
    EXPECT_FALSE(info.set(options, info.default_value())) << info.name;
    EXPECT_EQ(info.get(options), info.default_value());
    EXPECT_FALSE(info.check(options));
    if (!info.choices.empty()) {
      for (std::string_view choice : info.choices) {
        ASSERT_FALSE(info.set(options, std::string(choice)));
        EXPECT_EQ(info.get(options), OptionValue(std::string(choice)));
      }
      const auto wrong = info.set(options, std::string("neither"));
      ASSERT_TRUE(wrong);
      EXPECT_NE(wrong->find(info.choices[0]), std::string::npos);
    } else {
      const auto wrong = info.set(options, -1e300);
      ASSERT_TRUE(wrong) << info.name;
      EXPECT_NE(wrong->find(info.name), std::string::npos);
      EXPECT_TRUE(info.set(options, std::string("text")));
    }
  }
}

TEST(OptionTable, NamesUnknownChoices) {
  for (const int number : {-1, 3}) {
    SolverOptions options;
    options.hessian = static_cast<HessianChoice>(number);
    const auto messages = options.validate();
    ASSERT_FALSE(messages.empty()) << number;
    EXPECT_EQ(messages[0], "hessian must be one of automatic, gauss_newton, exact") << number;
  }
}

TEST(OptionTable, RequiresWholeNumbersWhereNeeded) {
  SolverOptions options;
  const OptionInfo* info = find_option("max_iterations");
  EXPECT_TRUE(info->set(options, 1.5));
  EXPECT_FALSE(info->set(options, 7.0));
  EXPECT_EQ(options.max_iterations, 7);
}

}  // namespace
}  // namespace conddp
