#include "batch/plan/sobol.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace conddp {
namespace {

TEST(Sobol, BeginsWithTheKnownPointsOfTwoCoordinates) {
  // Bratley and Fox (1988), algorithm 659: the sequence in Gray code order.
  const double known[][2] = {{0, 0},         {0.5, 0.5},     {0.75, 0.25},   {0.25, 0.75},
                             {0.375, 0.375}, {0.875, 0.875}, {0.625, 0.125}, {0.125, 0.625}};
  SobolSequence sequence(2, 0);
  for (const auto& point : known)
    EXPECT_EQ(sequence.next(), std::vector<double>({point[0], point[1]}));
}

TEST(Sobol, EveryCoordinateHasOnePointInEachInterval) {
  constexpr int kPoints = 1024;
  for (const std::uint64_t seed : {0, 1, 7}) {
    SobolSequence sequence(kSobolDimensions, seed);
    std::vector<std::vector<int>> counts(kSobolDimensions, std::vector<int>(kPoints));
    for (int i = 0; i < kPoints; ++i) {
      const std::vector<double> point = sequence.next();
      for (int c = 0; c < kSobolDimensions; ++c)
        ++counts[c][static_cast<int>(std::floor(point[c] * kPoints))];
    }
    for (const std::vector<int>& coordinate : counts)
      EXPECT_EQ(coordinate, std::vector<int>(kPoints, 1));
  }
}

// Two equal direction columns would put all points of two coordinates on a line.
TEST(Sobol, NoTwoCoordinatesAreTheSame) {
  SobolSequence sequence(kSobolDimensions, 0);
  std::vector<std::vector<double>> columns(kSobolDimensions);
  for (int i = 0; i < 64; ++i) {
    const std::vector<double> point = sequence.next();
    for (int c = 0; c < kSobolDimensions; ++c) columns[c].push_back(point[c]);
  }
  for (int a = 0; a < kSobolDimensions; ++a)
    for (int b = 0; b < a; ++b) EXPECT_NE(columns[a], columns[b]) << a << " " << b;
}

TEST(Sobol, TheSeedShiftsThePoints) {
  EXPECT_NE(SobolSequence(3, 1).next(), SobolSequence(3, 2).next());
  EXPECT_EQ(SobolSequence(3, 1).next(), SobolSequence(3, 1).next());
}

}  // namespace
}  // namespace conddp
