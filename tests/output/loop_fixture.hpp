#pragma once

#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "output/mpc/loop_files.hpp"
#include "problem_file/read/read_problem.hpp"
#include "support/balanced_cartpole.hpp"
#include "support/source_tree.hpp"

namespace conddp {

/// A cart-pole pushed near its upright state that moves differently from the model.
inline const std::string kBalancedCartpole =
    std::string("conddp: 1\nname: balance\n") + kBalancing + R"(mpc:
  horizon: 1
  tick: 0.02
  duration: 1.5
  delay: 0.005
  feedback: {rate: 200}
  plant: {set: {system.pole_mass: 0.25}, dt: 0.005}
  disturbances: [{at: 1, jump: {omega: 1}}, {noise: state, sigma: 0.001, seed: 3}]
  stop_when: {fallen: {residual: state, columns: theta, lower: 2.1, upper: 4.2}}
)";

/// A mass that bounces at 0.5 s.
inline constexpr const char* kBouncingMass = R"(conddp: 1
name: bounce
system: {states: {h: m, v: m/s}, controls: {u: N}, rate: {h: v, v: u - 9.81}}
initial_state: {values: {h: 1}}
integrator: rk4
phases:
  - {name: down, knots: 10, dt: 0.05}
  - {name: bounce, jump: {v: -0.8*v}}
  - {name: up, knots: 10, dt: 0.05}
costs: {effort: {residual: control}}
terminal: {costs: {rest: {residual: state, reference: {values: {h: 1}}, weight: 100}}}
solver: {name: box_fddp}
mpc: {horizon: 2, duration: 1, repeat: none, tick: 0.05}
)";

/// A mass on a spring whose rate changes much faster than its mean over a step.
inline constexpr const char* kStiffMass = R"(conddp: 1
name: stiff
system: {states: {p: m, v: m/s}, controls: {u: N}, rate: {p: v, v: u - 10000*p}}
initial_state: {values: {p: 1}}
integrator: rk4
phases: [{name: swing, knots: 200, dt: 0.002}]
costs: {track: {residual: state}, effort: {residual: control, weight: 0.01}}
solver: {name: box_fddp}
mpc: {horizon: 0.1, tick: 0.02, duration: 0.2, feedback: {rate: 300}}
)";

/// A simulated closed loop, with late ticks as a measured clock would report them.
struct SimulatedLoop {
  explicit SimulatedLoop(const std::string& text, const std::vector<std::string>& settings = {},
                         std::set<int> late = {}) {
    Diagnostics out;
    auto spec = read_problem_text(text, source_tree() / "problems" / "test.yaml", settings, out);
    if (spec) task = build_loop(*std::move(spec), {}, out);
    EXPECT_TRUE(task) << format_diagnostics(out, false);
    if (!task) return;
    if (!late.empty())
      task->mpc.controller.is_late = [late](int tick) { return late.contains(tick); };
    result = run_loop(*task);
    if (late.empty()) return;
    task->mpc.controller.is_late = nullptr;
    task->mpc.controller.clock = [] { return 0.0; };
  }
  LoopRun run() const { return {*task, result, {}}; }

  std::unique_ptr<LoopTask> task;
  ClosedLoopResult result;
};

}  // namespace conddp
