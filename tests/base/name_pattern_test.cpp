#include "base/text/name_pattern.hpp"

#include <gtest/gtest.h>

namespace conddp {
namespace {

TEST(NamePattern, MatchesNamesThatItsStarsComplete) {
  EXPECT_TRUE(fits("leg_*", "leg_front"));
  EXPECT_TRUE(fits("*", "a"));
  EXPECT_TRUE(fits("a*b*", "axxb"));
  EXPECT_TRUE(fits("leg", "leg"));
  EXPECT_FALSE(fits("leg", "legs"));
  EXPECT_FALSE(fits("leg_*", "a_leg_front"));
  EXPECT_FALSE(fits("*", ""));
  // Other wildcard characters are literals.
  EXPECT_FALSE(fits("le?", "leg"));
  EXPECT_FALSE(fits("[l]eg", "leg"));
  EXPECT_TRUE(is_pattern("le*"));
  EXPECT_FALSE(is_pattern("le?"));
}

TEST(NamePattern, ExactNameWinsThenTheLongerPattern) {
  EXPECT_GT(fit("leg_a", "leg_a"), fit("leg_*", "leg_a"));
  EXPECT_GT(fit("leg_*", "leg_a"), fit("*", "leg_a"));
  EXPECT_GT(fit("*", "leg_a"), fit("arm*", "leg_a"));
  EXPECT_EQ(fit("arm*", "leg_a"), 0u);
}

}  // namespace
}  // namespace conddp
