#include <algorithm>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "robot/dynamics.hpp"
#include "robot/urdf/urdf.hpp"
#include "support/random_robot.hpp"
#include "support/robots.hpp"
#include "support/source_tree.hpp"

// Rigid-body kernels with `double` (one knot at a time) and with `Lane` (kLaneWidth different knots
// at a time). The counter "knot" is the time per knot.

namespace conddp {
namespace {

/// A robot in random states, one per lane, and buffers for the kernels.
template <class S>
struct Bench {
  static constexpr int kKnots = sizeof(S) / sizeof(double);

  explicit Bench(const RobotModel& robot)
      : model(robot), data(robot), rhs(2 * robot.nv * robot.nv, S(0.0)) {
    RandomNumbers random(1);
    for (int lane = 0; lane < kKnots; ++lane) {
      const RobotState x = random_state(model, random);
      const auto fill = [lane](const std::vector<double>& from, AlignedVector<S>& to) {
        to.resize(from.size(), S(0.0));
        for (std::size_t i = 0; i < from.size(); ++i)
          reinterpret_cast<double*>(&to[i])[lane] = from[i];
      };
      fill(x.q, q);
      fill(x.v, v);
      fill(x.a, a);
      fill(x.tau, tau);
    }
    forward_dynamics(model, q.data(), v.data(), tau.data(), data);
  }

  const RobotModel& model;
  RobotData<S> data;
  AlignedVector<S> q, v, a, tau, rhs;
};

template <class S>
void rnea(Bench<S>& b) {
  inverse_dynamics(b.model, b.q.data(), b.v.data(), b.a.data(), b.data);
}

template <class S>
void crba(Bench<S>& b) {
  update_placements(b.model, b.q.data(), b.data);
  mass_matrix(b.model, b.data);
}

/// Inverse-dynamics derivatives and M from a state and accelerations: the linearization of the
/// dynamics without the solve with M.
template <class S>
void derivatives(Bench<S>& b) {
  update_placements(b.model, b.q.data(), b.data);
  update_velocities(b.model, b.v.data(), b.data);
  mass_matrix(b.model, b.data);
  std::copy(b.a.begin(), b.a.end(), b.data.acceleration.begin());
  inverse_dynamics_derivatives(b.model, b.v.data(), b.data);
}

template <class S>
void fd(Bench<S>& b) {
  forward_dynamics(b.model, b.q.data(), b.v.data(), b.tau.data(), b.data);
}

/// Factorizes M and solves for nv x 2 nv right-hand sides, as the acceleration derivatives with
/// respect to configuration and velocity require.
template <class S>
void solve(Bench<S>& b) {
  const int n = b.model.nv;
  factorize_mass_matrix(b.model, b.data);
  std::copy(b.data.tau_q.begin(), b.data.tau_q.end(), b.rhs.begin());
  std::copy(b.data.tau_v.begin(), b.data.tau_v.end(), b.rhs.begin() + n * n);
  solve_mass_matrix(b.model, b.data, b.rhs.data(), 2 * n);
}

template <class S>
void add(const std::string& name, const RobotModel& model, void (*work)(Bench<S>&)) {
  const std::string scalar = Bench<S>::kKnots == 1 ? "double" : "lanes";
  benchmark::RegisterBenchmark((name + "/" + scalar).c_str(), [=, &model](benchmark::State& state) {
    Bench<S> bench(model);
    for (auto _ : state) {
      benchmark::DoNotOptimize(bench.q.data());
      work(bench);
      benchmark::ClobberMemory();
    }
    state.SetItemsProcessed(state.iterations() * Bench<S>::kKnots);
    state.SetLabel(std::to_string(model.nv) + " DoF, " + std::to_string(Bench<S>::kKnots) +
                   (Bench<S>::kKnots == 1 ? " knot" : " knots"));
    state.counters["knot"] =
        benchmark::Counter(Bench<S>::kKnots, benchmark::Counter::kIsIterationInvariantRate |
                                                 benchmark::Counter::kInvert);
  });
}

std::vector<TestModel> load_robots() {
  const std::string folder = source_tree().string() + "/problems/robots/";
  const auto load = [&](const char* name, UrdfOptions::Base base) {
    return TestModel{name, load_urdf(folder + name + ".urdf", {.base = base}).model.value()};
  };
  std::vector<TestModel> robots = {load("quadruped", UrdfOptions::Base::floating),
                                   load("arm7", UrdfOptions::Base::fixed),
                                   {"humanoid_like", humanoid_like_robot(10)}};
  // If available, robots with published figures.
  for (const TestRobot& robot : foreign_robots())
    if (robot.name == "hyq" || robot.name == "panda" || robot.name == "talos_reduced")
      robots.push_back({robot.name, load_urdf(robot.urdf, {.base = robot.base}).model.value()});
  return robots;
}

const bool kRegistered = [] {
  static const std::vector<TestModel> robots = load_robots();
  for (const TestModel& robot : robots) {
    const auto add_both = [&](const char* name, void (*one)(Bench<double>&),
                              void (*many)(Bench<Lane>&)) {
      add(robot.name + "/" + name, robot.model, one);
      add(robot.name + "/" + name, robot.model, many);
    };
    add_both("rnea", rnea<double>, rnea<Lane>);
    add_both("crba", crba<double>, crba<Lane>);
    add_both("derivatives_and_M", derivatives<double>, derivatives<Lane>);
    add_both("forward_dynamics", fd<double>, fd<Lane>);
    add_both("factor_and_solve", solve<double>, solve<Lane>);
  }
  return true;
}();

}  // namespace
}  // namespace conddp
