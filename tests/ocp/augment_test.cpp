#include <gtest/gtest.h>

#include "ocp/knot/augmented_term.hpp"
#include "ocp/problem/problem.hpp"
#include "ocp/residuals/residuals.hpp"
#include "support/random_numbers.hpp"

// Constraint contributions to the cost, compared with their definition by distances; derivatives,
// compared with dual numbers.

namespace conddp {
namespace {

constexpr int kRows = 4;

struct AugmentedKind {
  const char* name;
  ConstraintKind kind;
  Softness softness;
};

constexpr AugmentedKind kAugmentedKinds[] = {
    {"bounds", ConstraintKind::bounds, Softness::hard},
    {"soft_bounds", ConstraintKind::bounds, Softness::l1},
    {"cone", ConstraintKind::second_order_cone, Softness::hard},
    {"soft_cone", ConstraintKind::second_order_cone, Softness::l1},
    {"pairs", ConstraintKind::complementarity, Softness::hard},
};

ConstraintTerm term_of(ConstraintKind kind, Softness softness) {
  return make_constraint("c", control_residual(0, kRows), kind, 1, softness);
}

/// Values of a constraint with its parameters and multipliers.
struct Sample {
  std::vector<double> g, lower, upper, penalty, shift, multiplier;
  double limit;

  Sample(RandomNumbers& random, const ConstraintTerm& term)
      : g(random.numbers(kRows, 2)),
        lower(random.numbers(kRows, 1)),
        upper(lower),
        penalty(kRows, random.uniform(0.3, 3)),
        shift(random.numbers(kRows, 0.5)),
        multiplier(random.numbers(kRows, 1)),
        limit(random.uniform(0.2, 1.5)) {
    upper[1] += 0.5;
    upper[2] = std::numeric_limits<double>::infinity();
    upper[3] += 2;
    if (!term.is_cone())
      for (double& each : penalty) each = random.uniform(0.3, 3);
  }
  NodeConstraint at(const ConstraintTerm& term) const {
    NodeConstraint c{0, &term, 0, lower.data(), upper.data()};
    if (term.softness == Softness::l1) c.limit = limit;
    return c;
  }
  std::vector<double> shifted() const {
    std::vector<double> s(g);
    for (int i = 0; i < kRows; ++i) s[i] += shift[i];
    return s;
  }
};

template <class S>
struct Augmented {
  S value;
  std::vector<S> weight, curvature;
};

/// Augmentation of a sample whose values move along a direction; −1: constant values.
template <class S>
Augmented<S> augmented(const ConstraintTerm& term, const Sample& sample, int direction = -1) {
  const auto as = [](const std::vector<double>& a) { return std::vector<S>(a.begin(), a.end()); };
  std::vector<S> g = as(sample.g);
  if constexpr (!std::is_same_v<S, double>)
    if (direction >= 0) g[direction].d = Lane(1.0);
  const std::vector<S> lower = as(sample.lower), upper = as(sample.upper),
                       penalty = as(sample.penalty), shift = as(sample.shift),
                       multiplier = as(sample.multiplier);
  std::vector<S> shifted(kRows);
  Augmented<S> result{S(0.0), std::vector<S>(kRows), std::vector<S>(kRows * kRows)};
  result.value =
      augment(term, RowSet<S>{lower.data(), upper.data(), S(sample.limit)},
              RowPenalty<S>{penalty.data(), shift.data(), multiplier.data()}, g.data(),
              RowSlopes<S>{shifted.data(), result.weight.data(), result.curvature.data()});
  return result;
}

/// ½ ρ d² of a distance d, linear if ρ d exceeds the limit.
double limited_square(double distance, double penalty, double limit) {
  const double kink = limit / penalty;
  return distance <= kink ? 0.5 * penalty * distance * distance : limit * (distance - 0.5 * kink);
}

class AugmentedTerm : public testing::TestWithParam<AugmentedKind> {
 protected:
  template <class F>
  void sampled(F test) const {
    const ConstraintTerm term = term_of(GetParam().kind, GetParam().softness);
    RandomNumbers random(31);
    for (int i = 0; i < 60; ++i) {
      test(term, Sample(random, term));
      if (testing::Test::HasFailure()) return;
    }
  }
};

TEST_P(AugmentedTerm, CostsSquaredDistanceUpToSoftLimit) {
  if (GetParam().kind == ConstraintKind::complementarity) return;  // adds derivatives only
  sampled([](const ConstraintTerm& term, const Sample& sample) {
    const NodeConstraint c = sample.at(term);
    const std::vector<double> s = sample.shifted();
    double expected = 0;
    for (int i = 0; i < kRows; ++i) expected += sample.multiplier[i] * sample.g[i];
    if (term.is_cone())
      expected += limited_square(distance_to_set(term, s.data(), nullptr, nullptr),
                                 sample.penalty[0], c.limit);
    for (int i = 0; term.has_bounds() && i < kRows; ++i)
      expected += limited_square(std::max({sample.lower[i] - s[i], s[i] - sample.upper[i], 0.0}),
                                 sample.penalty[i], c.limit);
    EXPECT_NEAR(augmented<double>(term, sample).value, expected, 1e-12);
  });
}

TEST_P(AugmentedTerm, DerivativesMatchDualNumbers) {
  using D = Dual<Lane>;
  sampled([](const ConstraintTerm& term, const Sample& sample) {
    const Augmented<double> at = augmented<double>(term, sample);
    for (int j = 0; j < kRows; ++j) {
      const Augmented<D> moved = augmented<D>(term, sample, j);
      if (!term.has_pairs()) {
        EXPECT_NEAR(at.weight[j], moved.value.d[0], 1e-12) << j;
      }
      for (int i = 0; i < kRows; ++i) {
        const double curvature = term.is_cone() ? at.curvature[j * kRows + i]
                                 : i == j       ? at.curvature[i]
                                                : 0;
        EXPECT_NEAR(curvature, moved.weight[i].d[0], 1e-12) << i << " by " << j;
      }
    }
  });
}

TEST_P(AugmentedTerm, GivesTheNextMultipliers) {
  if (GetParam().kind == ConstraintKind::complementarity) return;
  sampled([](const ConstraintTerm& term, const Sample& sample) {
    const std::vector<double> s = sample.shifted();
    const Augmented<double> at = augmented<double>(term, sample);
    for (int i = 0; i < kRows; ++i) {
      std::vector<double> next(kRows);
      next_multipliers(sample.at(term), s.data(), sample.penalty[i], next.data());
      EXPECT_NEAR(at.weight[i], next[i] + sample.multiplier[i], 1e-12);
    }
  });
}

TEST_P(AugmentedTerm, EqualsTheLagrangianWithoutPenalty) {
  sampled([](const ConstraintTerm& term, Sample sample) {
    std::fill(sample.penalty.begin(), sample.penalty.end(), 0.0);
    const Augmented<double> at = augmented<double>(term, sample);
    double expected = 0;
    for (int i = 0; i < kRows; ++i) expected += sample.multiplier[i] * sample.g[i];
    EXPECT_NEAR(at.value, expected, 1e-15);
    EXPECT_EQ(at.weight, sample.multiplier);
  });
}

INSTANTIATE_TEST_SUITE_P(All, AugmentedTerm, testing::ValuesIn(kAugmentedKinds),
                         [](const auto& suite) { return std::string(suite.param.name); });

/// Curvature of rows with penalty 2, per row or for a whole cone.
std::vector<double> curvature_at(const ConstraintTerm& term, std::vector<double> g,
                                 std::vector<double> lower, std::vector<double> upper,
                                 double limit = 100) {
  RandomNumbers random(1);
  Sample sample(random, term);
  sample.g = std::move(g);
  sample.lower = std::move(lower);
  sample.upper = std::move(upper);
  sample.penalty.assign(kRows, 2.0);
  sample.shift.assign(kRows, 0.0);
  sample.limit = limit;
  std::vector<double> all = augmented<double>(term, sample).curvature;
  if (!term.is_cone()) all.resize(kRows);
  return all;
}

// Exactly satisfied equalities stay stiff, and so do active bounds.
TEST(AugmentedBounds, AreStiffOnTheBoundItself) {
  const ConstraintTerm bounds = term_of(ConstraintKind::bounds, Softness::hard);
  EXPECT_EQ(curvature_at(bounds, {1, -1, 2, 0}, {1, -1, 0, -1}, {1, 5, 2, 1}),
            (std::vector<double>{2, 2, 2, 0}));
  // Equally stiff with the multiplier exactly at its limit, but not beyond.
  const ConstraintTerm soft = term_of(ConstraintKind::bounds, Softness::l1);
  EXPECT_EQ(curvature_at(soft, {3, -3, 3.5, -3.5}, {-1, -1, -1, -1}, {1, 1, 1, 1}, 4),
            (std::vector<double>{2, 2, 0, 0}));
}

TEST(AugmentedCone, IsFlatOnConeAndStiffOnPolar) {
  const ConstraintTerm cone = term_of(ConstraintKind::second_order_cone, Softness::hard);
  EXPECT_EQ(curvature_at(cone, {2, 3, 6, 7}, {}, {}), std::vector<double>(16, 0.0));
  const std::vector<double> polar = curvature_at(cone, {2, 3, 6, -7}, {}, {});
  for (int i = 0; i < 16; ++i) EXPECT_EQ(polar[i], i % 5 == 0 ? 2 : 0) << i;
}

// The smaller value of a pair must vanish, the first one of equal values.
TEST(AugmentedPairs, PushTheSmallerOneToZero) {
  const ConstraintTerm pairs = term_of(ConstraintKind::complementarity, Softness::hard);
  EXPECT_EQ(curvature_at(pairs, {0.1, 3, 3, 0.1}, {}, {}), (std::vector<double>{2, 0, 0, 2}));
  EXPECT_EQ(curvature_at(pairs, {0.5, 0.5, 0, 0}, {}, {}), (std::vector<double>{2, 0, 2, 2}));
  EXPECT_EQ(curvature_at(pairs, {-1, -2, -2, -1}, {}, {}), (std::vector<double>{2, 2, 2, 2}));
}

TEST(AugmentedPairs, DistanceIsThatOfTheSmallerOne) {
  const ConstraintTerm pairs = term_of(ConstraintKind::complementarity, Softness::hard);
  const auto distance = [&](std::vector<double> g) {
    return distance_to_set(pairs, g.data(), nullptr, nullptr);
  };
  EXPECT_EQ(distance({0.25, 3, 2, 0.5}), 0.5);
  EXPECT_EQ(distance({3, 0.75, 0.5, 2}), 0.75);
  EXPECT_EQ(distance({-3, 1, 1, -4}), 4);
  EXPECT_EQ(distance({0, 5, 5, 0}), 0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < kRows; ++i) {
    std::vector<double> g(kRows, 1.0);
    g[i] = nan;
    EXPECT_TRUE(std::isnan(distance(g))) << i;
  }
}

TEST(AugmentedPairs, AreComplementaryWithoutMultipliersOnLargerValues) {
  const ConstraintTerm pairs = term_of(ConstraintKind::complementarity, Softness::hard);
  const auto off = [&](std::vector<double> g, std::vector<double> nu) {
    return complementarity(pairs, g.data(), nullptr, nullptr, nu.data());
  };
  EXPECT_EQ(off({0, 3, 2, 0}, {-5, 0, 0, 7}), 0);
  EXPECT_EQ(off({0, 3, 2, 0}, {-5, 0.5, -0.25, 7}), 1.5);
  EXPECT_EQ(off({0, 3, 2, 0}, {-5, 0.5, -2, 7}), 4);
  EXPECT_EQ(off({2, 2, 0, 0}, {9, 0.5, 1, 1}), 1);  // the second of equal values
}

TEST(AugmentedPairs, UseSingleEntriesInPairs) {
  EXPECT_THROW(make_constraint("c", control_residual(0, 3), ConstraintKind::complementarity),
               std::invalid_argument);
  const ConstraintTerm pairs = term_of(ConstraintKind::complementarity, Softness::hard);
  EXPECT_EQ(pairs.rows, kRows);
  EXPECT_FALSE(pairs.has_bounds());
  EXPECT_EQ(pairs.active(), pairs.lower());
}

TEST(BoundComplementarity, IsMultiplierTimesDistanceToItsBound) {
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(bound_complementarity(1, -1, 4, 2), 6);
  EXPECT_EQ(bound_complementarity(1, -1, 4, -2), 4);
  EXPECT_EQ(bound_complementarity(1, -1, 4, 0), 0);
  EXPECT_EQ(bound_complementarity(5, -1, 4, 2), 0);  // outside is a violation
  EXPECT_EQ(bound_complementarity(-3, -1, 4, -2), 0);
  EXPECT_EQ(bound_complementarity(1, -infinity, 4, -2), 2);
  EXPECT_EQ(bound_complementarity(1, -1, infinity, 3), 3);
  EXPECT_EQ(bound_complementarity(1, 2, 2, 3), 0);
}

TEST(PolarCone, DistanceMatchesConeDistanceOfNegatedMultipliers) {
  const ConstraintTerm cone = term_of(ConstraintKind::second_order_cone, Softness::hard);
  RandomNumbers random(32);
  for (int i = 0; i < 40; ++i) {
    const std::vector<double> nu = random.numbers(kRows, 1);
    std::vector<double> opposite(nu);
    for (double& each : opposite) each = -each;
    EXPECT_NEAR(distance_to_polar_cone(nu.data(), kRows),
                distance_to_set(cone, opposite.data(), nullptr, nullptr), 1e-14);
  }
  const double inside[] = {1, 2, 2, -4};
  EXPECT_EQ(distance_to_polar_cone(inside, kRows), 0);
}

TEST(SoftBounds, AreComplementaryWithMultipliersAtTheirLimit) {
  const ConstraintTerm soft =
      make_constraint("c", control_residual(0, 1), ConstraintKind::bounds, 1, Softness::l1);
  const double lower = -1, upper = 2;
  const auto off = [&](double g, double nu) {
    const NodeConstraint c{0, &soft, 0, &lower, &upper, 3};
    EXPECT_EQ(violation(c, &g), 0);
    return complementarity(c, &g, &nu);
  };
  EXPECT_EQ(off(2.5, 3), 0);
  EXPECT_EQ(off(2.5, 1), 0.5 * 2);
  EXPECT_EQ(off(2.5, -1), 3.5);  // points away from the set: its bound is the other one
  EXPECT_EQ(off(-3, -3), 0);
  EXPECT_EQ(off(-3, -2.5), 2 * 0.5);
  EXPECT_EQ(off(0, 0), 0);
  EXPECT_EQ(off(0, 1), 2);
  EXPECT_EQ(off(2, 1), 0);
  EXPECT_EQ(off(2, 5), 2);  // beyond the limit
  EXPECT_EQ(off(-1, -4.5), 1.5);
}

TEST(SoftConstraint, HasNoViolationUnlikeAHardOne) {
  const ConstraintTerm hard = term_of(ConstraintKind::bounds, Softness::hard);
  const std::vector<double> lower(kRows, -1), upper(kRows, 2), g = {0, 2.5, -3, 1};
  EXPECT_EQ(violation({0, &hard, 0, lower.data(), upper.data()}, g.data()), 2);
}

TEST(SoftConstraint, CostsWeightedDistanceOrHalfItsSquare) {
  const std::vector<double> g = {0, 2.5, -3, 4};
  // References and bounds of four rows each, the switch, and the weight.
  std::vector<double> parameters = {0, 0, 0, 0, -1, -1, -1, -1, 2, 2, 2, 2, 1, 3};
  const auto cost = [&](Softness softness) {
    return soft_cost(term_of(ConstraintKind::bounds, softness), g.data(), parameters.data(), 0.5);
  };
  EXPECT_EQ(cost(Softness::hard), 0);
  EXPECT_EQ(cost(Softness::l1), 0.5 * 3 * (0.5 + 2 + 2));
  EXPECT_EQ(cost(Softness::l2), 0.5 * 0.5 * 3 * (0.25 + 4 + 4));
  parameters[12] = 0;
  EXPECT_EQ(cost(Softness::l1), 0);
  EXPECT_EQ(cost(Softness::l2), 0);

  const std::vector<double> below = {2, 3, 6, -8}, of_cone = {0, 0, 0, 0, 1, 3};
  const double distance = std::sqrt(4. + 9 + 36 + 64);
  const auto cone_cost = [&](Softness softness) {
    return soft_cost(term_of(ConstraintKind::second_order_cone, softness), below.data(),
                     of_cone.data(), 0.5);
  };
  EXPECT_NEAR(cone_cost(Softness::l1), 0.5 * 3 * distance, 1e-12);
  EXPECT_NEAR(cone_cost(Softness::l2), 0.5 * 0.5 * 3 * distance * distance, 1e-12);
}

}  // namespace
}  // namespace conddp
