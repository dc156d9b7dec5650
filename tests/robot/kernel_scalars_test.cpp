#include <limits>

#include <gtest/gtest.h>

#include "support/kernel_probe.hpp"

// The kernels agree for every scalar, and lanes are independent.

namespace conddp {
namespace {

/// Different states, one per lane.
std::vector<RobotState> lane_states(const RobotModel& model, std::uint64_t seed) {
  RandomNumbers random(seed);
  std::vector<RobotState> states;
  for (int i = 0; i < kLaneWidth; ++i) states.push_back(random_state(model, random));
  return states;
}

void set_lane(Lane& target, int lane, double value) { target.set(lane, value); }
void set_lane(Dual<Lane>& target, int lane, const Dual<double>& value) {
  target.v.set(lane, value.v);
  target.d.set(lane, value.d);
}

template <class Wide, class Narrow>
ProbeState<Wide> pack(const std::vector<ProbeState<Narrow>>& states) {
  ProbeState<Wide> packed;
  for (auto part : {std::pair{&ProbeState<Wide>::q, &ProbeState<Narrow>::q},
                    std::pair{&ProbeState<Wide>::v, &ProbeState<Narrow>::v},
                    std::pair{&ProbeState<Wide>::a, &ProbeState<Narrow>::a},
                    std::pair{&ProbeState<Wide>::tau, &ProbeState<Narrow>::tau}}) {
    std::vector<Wide>& wide = packed.*part.first;
    wide.resize((states[0].*part.second).size());
    for (int lane = 0; lane < kLaneWidth; ++lane)
      for (std::size_t i = 0; i < wide.size(); ++i)
        set_lane(wide[i], lane, (states[lane].*part.second)[i]);
  }
  return packed;
}

std::vector<double> lane_of(const std::vector<Lane>& values, int lane) {
  std::vector<double> one;
  for (const Lane& value : values) one.push_back(value[lane]);
  return one;
}
std::vector<double> values_of(const std::vector<Dual<double>>& duals) {
  std::vector<double> values;
  for (const Dual<double>& dual : duals) values.push_back(dual.v);
  return values;
}
std::vector<double> slopes_of(const std::vector<Dual<double>>& duals) {
  std::vector<double> slopes;
  for (const Dual<double>& dual : duals) slopes.push_back(dual.d);
  return slopes;
}

class KernelScalars : public testing::TestWithParam<std::size_t> {
 protected:
  const RobotModel& model() const { return kernel_models()[GetParam()].model; }

  std::vector<ProbeState<double>> states() const {
    std::vector<ProbeState<double>> all;
    for (const RobotState& x : lane_states(model(), 400 + GetParam()))
      all.push_back(ProbeState<double>::at(x));
    return all;
  }

  /// The states, each moving along its own direction.
  std::vector<ProbeState<Dual<double>>> moving_states() const {
    RandomNumbers random(500 + GetParam());
    std::vector<ProbeState<Dual<double>>> all;
    for (const RobotState& x : lane_states(model(), 400 + GetParam())) {
      auto state = ProbeState<Dual<double>>::at(x);
      std::vector<Dual<double>> step(model().nv);
      for (int i = 0; i < model().nv; ++i) {
        step[i] = {0.0, random.uniform(-1, 1)};
        state.v[i].d = random.uniform(-1, 1);
        state.a[i].d = random.uniform(-1, 1);
        state.tau[i].d = random.uniform(-1, 1);
      }
      state.q = move_configuration(model(), state.q, step);
      all.push_back(state);
    }
    return all;
  }
};

// Tolerance for rounding: compilers order fused multiplications differently, and sines differ in
// the last bit. Accelerations amplify both by the condition of M.
double rounding_of(const std::string& output) {
  return output.starts_with("acceleration") ? 1e-10 : 1e-12;
}

/// The condition of M amplifies rounding of its factors, but not of their product. Expects Lᵀ D L =
/// M (column-major lower triangles, D on the diagonal of L), relative to the sum of product
/// magnitudes. For values, that sum is the size of M; for slopes, it accounts for cancellation.
void expect_factors(int n, const std::vector<Dual<double>>& L, const std::vector<Dual<double>>& M,
                    const std::string& where) {
  Dual<double> largest(0.0), worst(0.0);
  for (int a = 0; a < n; ++a) {
    for (int b = 0; b <= a; ++b) {
      Dual<double> difference = M[b * n + a];
      Dual<double> size(0.0);
      for (int i = a; i < n; ++i) {
        const Dual<double> left = i == a ? Dual<double>(1.0) : L[a * n + i];
        const Dual<double> right = i == b ? Dual<double>(1.0) : L[b * n + i];
        const Dual<double> pivot = L[i * n + i];
        difference -= left * pivot * right;
        size.v += std::abs(left.v * pivot.v * right.v);
        size.d += std::abs(left.d * pivot.v * right.v) + std::abs(left.v * pivot.d * right.v) +
                  std::abs(left.v * pivot.v * right.d);
      }
      largest = {std::max(largest.v, size.v), std::max(largest.d, size.d)};
      worst = {std::max(worst.v, std::abs(difference.v)),
               std::max(worst.d, std::abs(difference.d))};
    }
  }
  EXPECT_LE(worst.v, 1e-12 * largest.v) << where;
  EXPECT_LE(worst.d, 1e-12 * largest.d) << where;
}

std::vector<Dual<double>> as_duals(const std::vector<double>& values) {
  return as_scalars<Dual<double>>(values);
}
std::vector<Dual<double>> lane_of(const std::vector<Dual<Lane>>& values, int lane) {
  std::vector<Dual<double>> one;
  for (const Dual<Lane>& value : values) one.push_back({value.v[lane], value.d[lane]});
  return one;
}

TEST_P(KernelScalars, LanesEqualDouble) {
  const std::vector<ProbeState<double>> all = states();
  const KernelProbe<Lane> wide(model(), pack<Lane>(all));
  for (int lane = 0; lane < kLaneWidth; ++lane) {
    const KernelProbe<double> one(model(), all[lane]);
    const std::string in_lane = " in lane " + std::to_string(lane);
    for (const auto& [name, values] : one.outputs()) {
      if (name == "L") continue;
      expect_close(lane_of(wide[name], lane), values, rounding_of(name), name + in_lane);
    }
    expect_factors(model().nv, as_duals(lane_of(wide["L"], lane)),
                   as_duals(lane_of(wide["M"], lane)), "L" + in_lane);
    expect_factors(model().nv, as_duals(one["L"]), as_duals(one["M"]), "L of double");
  }
}

TEST_P(KernelScalars, DualLanesEqualDual) {
  const std::vector<ProbeState<Dual<double>>> all = moving_states();
  const KernelProbe<Dual<Lane>> wide(model(), pack<Dual<Lane>>(all));
  for (int lane = 0; lane < kLaneWidth; ++lane) {
    const KernelProbe<Dual<double>> one(model(), all[lane]);
    const std::string in_lane = " in lane " + std::to_string(lane);
    for (const auto& [name, duals] : one.outputs()) {
      if (name == "L") continue;
      const std::vector<Dual<double>> actual = lane_of(wide[name], lane);
      expect_close(values_of(actual), values_of(duals), rounding_of(name), name + in_lane);
      expect_close(slopes_of(actual), slopes_of(duals), rounding_of(name), name + in_lane);
    }
    expect_factors(model().nv, lane_of(wide["L"], lane), lane_of(wide["M"], lane), "L" + in_lane);
    expect_factors(model().nv, one["L"], one["M"], "L of duals");
  }
}

TEST_P(KernelScalars, DualValuesEqualDouble) {
  const std::vector<ProbeState<double>> all = states();
  const std::vector<ProbeState<Dual<double>>> moving = moving_states();
  const KernelProbe<double> plain(model(), all[0]);
  const KernelProbe<Dual<double>> dual(model(), moving[0]);
  for (const auto& [name, values] : plain.outputs()) {
    if (name == "L") continue;
    expect_close(values_of(dual[name]), values, rounding_of(name), name);
  }
}

// A diverged knot must not change a single bit of its neighbors in the register.
TEST_P(KernelScalars, GarbageStaysInItsLane) {
  std::vector<ProbeState<double>> all = states();
  const KernelProbe<Lane> clean(model(), pack<Lane>(all));
  const int bad = static_cast<int>(GetParam()) % kLaneWidth;
  for (const double rubbish :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300}) {
    for (auto part : {&ProbeState<double>::q, &ProbeState<double>::v, &ProbeState<double>::a,
                      &ProbeState<double>::tau})
      std::fill((all[bad].*part).begin(), (all[bad].*part).end(), rubbish);
    const KernelProbe<Lane> soiled(model(), pack<Lane>(all));
    for (const auto& [name, values] : clean.outputs()) {
      const std::vector<Lane>& others = soiled[name];
      for (int lane = 0; lane < kLaneWidth; ++lane)
        if (lane != bad) {
          ASSERT_EQ(lane_of(others, lane), lane_of(values, lane)) << name;
        }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(AllRobots, KernelScalars,
                         testing::Range<std::size_t>(0, kernel_models().size()),
                         [](const auto& suite) { return kernel_models()[suite.param].name; });

}  // namespace
}  // namespace conddp
