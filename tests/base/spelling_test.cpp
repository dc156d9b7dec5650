#include "base/text/spelling.hpp"

#include <gtest/gtest.h>

namespace conddp {
namespace {

using Names = std::vector<std::string>;

// The optimal string alignment distance: insertions, deletions, substitutions and swaps of
// neighbors.
TEST(EditDistance, MatchesTextbooks) {
  EXPECT_EQ(edit_distance("", ""), 0);
  EXPECT_EQ(edit_distance("", "abc"), 3);
  EXPECT_EQ(edit_distance("abc", ""), 3);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3);
  EXPECT_EQ(edit_distance("saturday", "sunday"), 3);
  EXPECT_EQ(edit_distance("flaw", "lawn"), 2);
  EXPECT_EQ(edit_distance("ca", "abc"), 3);  // 2 if a swapped pair could be edited again
  EXPECT_EQ(edit_distance("ab", "ba"), 1);
  EXPECT_EQ(edit_distance("elbwo_2", "elbow_2"), 1);
  EXPECT_EQ(edit_distance("xelbow", "elbow"), 1);
  EXPECT_EQ(edit_distance("elbow", "xelbow"), 1);
  EXPECT_EQ(edit_distance("a", "b"), 1);
}

TEST(EditDistance, TreatsCapitalsAsSmallLetters) {
  EXPECT_EQ(edit_distance("LF_Foot", "lf_foot"), 0);
  EXPECT_EQ(edit_distance("AB", "ba"), 1);
}

TEST(NearNames, AreWithinAThirdOfTheLetters) {
  // Two letters allow one edit, six allow two, twelve or more allow three.
  EXPECT_EQ(similar_names("hp", {"hip", "hips"}), (Names{"hip"}));
  EXPECT_EQ(similar_names("ankles", {"anlke", "nkle", "ank"}), (Names{"anlke", "nkle"}));
  EXPECT_EQ(similar_names("abcdefghijkl", {"abcdefghi", "abcdefgh"}), (Names{"abcdefghi"}));
  EXPECT_EQ(similar_names("abcdefghijklmnopqr", {"abcdefghijklmno", "abcdefghijklmn"}),
            (Names{"abcdefghijklmno"}));
}

TEST(NearNames, ShareALetter) {
  EXPECT_EQ(similar_names("e", {"a", "V", "t"}), Names{});
  EXPECT_EQ(similar_names("T", {"a", "V", "t"}), Names{"t"});
  EXPECT_EQ(similar_names("x", {"x1", "y", "ab"}), Names{"x1"});
}

TEST(Counted, UsesPluralExceptForOne) {
  EXPECT_EQ(counted(0, "row"), "0 rows");
  EXPECT_EQ(counted(1, "row"), "1 row");
  EXPECT_EQ(counted(2, "row"), "2 rows");
}

TEST(NearNames, TheNearestThreeComeFirst) {
  EXPECT_EQ(similar_names("abcdef", {"abcd", "abcdxx", "abcde", "abcdf", "abcdefg"}),
            (Names{"abcde", "abcdefg", "abcdf"}));
}

TEST(NameHint, SuggestsTheNearestNamesOrListsAll) {
  const Names legs{"LF_HAA", "LF_HFE", "RF_HAA", "tail"};
  EXPECT_EQ(name_hint("tial", legs, "joints"), "did you mean 'tail'?");
  EXPECT_EQ(name_hint("wing_tip", legs, "joints"), "joints: LF_HAA, LF_HFE, RF_HAA, tail");
  EXPECT_EQ(name_hint("a", {}, "joints"), "there are no joints");
}

TEST(NearNames, SkipVeryLongNames) {
  const std::string longest(128, 'a'), longer(129, 'a');
  EXPECT_EQ(similar_names(longest, {longest, longer}), (Names{longest}));
  EXPECT_EQ(similar_names(longer, {longest, longer}), Names{});
}

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
