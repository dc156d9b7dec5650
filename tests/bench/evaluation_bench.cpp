// Evaluator time per knot on whole problems, a few iterations from the guess. Parts of
// `differentiate` are measured on full lanes of the first phase: dynamics only, with cost
// gradients, with cost Hessians.
#include <memory>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "ocp/evaluation/evaluator.hpp"
#include "ocp/knot/knot_model.hpp"
#include "problem_file/assemble/build.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/foreign_problems.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

constexpr int kIterations = 5;

/// A problem and its iterate for the measurement.
struct Case {
  std::string name;
  ProblemSpec spec;
  BuiltProblem built;
  SolveResult iterate;

  const ShootingProblem& problem() const { return *built.problem; }
};

std::unique_ptr<Case> make_case(std::string name, std::optional<ProblemSpec> spec,
                                Diagnostics& diagnostics) {
  if (!spec) throw std::runtime_error(format_diagnostics(diagnostics, false));
  auto built = build_problem(*spec, {}, diagnostics);
  if (!built) throw std::runtime_error(format_diagnostics(diagnostics, false));
  SolverOptions options = spec->solver.options;
  options.max_iterations = kIterations;
  options.hessian = HessianChoice::gauss_newton;
  SolveResult iterate = solve(*built->problem, "box_fddp", options, built->guess);
  return std::make_unique<Case>(
      Case{std::move(name), std::move(*spec), std::move(*built), std::move(iterate)});
}

std::vector<std::unique_ptr<Case>> load_cases() {
  std::vector<std::unique_ptr<Case>> cases;
  Diagnostics diagnostics;
  for (const char* name : {"quadruped_trot", "biped_squat", "arm_reach", "quadrotor_zigzag",
                           "cartpole_swingup_closed_form"}) {
    const auto file = source_tree() / "problems" / name;
    cases.push_back(
        make_case(name, read_problem(file.string() + ".yaml", {}, diagnostics), diagnostics));
  }
  for (const auto& [name, foreign] :
       {std::pair("hyq_trot", hyq_trot()), std::pair("talos_squat", talos_squat())})
    if (foreign)
      cases.push_back(make_case(name, read_problem(foreign->file, foreign->settings, diagnostics),
                                diagnostics));
  return cases;
}

void count_knots(benchmark::State& state, int knots) {
  state.counters["knot"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * knots,
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

/// Times act(evaluator, case) over all running knots.
template <class F>
void add_benchmark(const Case& c, const char* name, F act) {
  benchmark::RegisterBenchmark((c.name + "/" + name).c_str(), [&c, act](benchmark::State& state) {
    Evaluator evaluator(c.problem());
    auto run = act(evaluator, c);
    for (auto _ : state) {
      run();
      benchmark::ClobberMemory();
    }
    count_knots(state, c.problem().knots());
  });
}

/// Times work(model, batch) with a knot of the first phase in every lane.
template <class F>
void add_part(const Case& c, const char* name, F work) {
  benchmark::RegisterBenchmark((c.name + "/" + name).c_str(), [&c, work](benchmark::State& state) {
    const KnotModel& model = *c.problem().knot(0).model;
    KnotBatch<Lane> batch(model);
    for (int l = 0; l < kLaneWidth; ++l) {
      const int k = l % c.problem().phases().front().knots();
      const KnotView& view = c.problem().knot(k);
      for (int i = 0; i < model.nx(); ++i) batch.x[i].set(l, c.iterate.trajectory.x(k)[i]);
      for (int i = 0; i < model.nu(); ++i) batch.u[i].set(l, c.iterate.trajectory.u(k)[i]);
      for (int i = 0; i < model.parameter_count(); ++i)
        batch.parameters[i].set(l, view.parameters[i]);
      batch.dt.set(l, view.dt);
      batch.cost_scale.set(l, view.cost_scale);
    }
    auto run = work(model, batch);
    for (auto _ : state) {
      run();
      benchmark::ClobberMemory();
    }
    count_knots(state, kLaneWidth);
  });
}

void add_case(const Case& c) {
  add_benchmark(c, "evaluate", [](Evaluator& evaluator, const Case& at) {
    return [&evaluator, &at, out = Evaluation(at.problem())]() mutable {
      evaluator.evaluate(at.iterate.trajectory, out);
    };
  });
  add_benchmark(c, "differentiate", [](Evaluator& evaluator, const Case& at) {
    return [&evaluator, &at, out = Linearization(at.problem())]() mutable {
      evaluator.differentiate(at.iterate.trajectory, out);
    };
  });
  add_benchmark(c, "lagrangian_hessian", [](Evaluator& evaluator, const Case& at) {
    return [&evaluator, &at, out = Linearization(at.problem())]() mutable {
      evaluator.lagrangian_hessian(at.iterate.trajectory, at.iterate.costates, out);
    };
  });
  add_benchmark(c, "lagrangian_hessian_by_dual_numbers", [](Evaluator& evaluator, const Case& at) {
    evaluator.reserve_lagrangian_hessian(false);
    return [&evaluator, &at, out = Linearization(at.problem())]() mutable {
      evaluator.lagrangian_hessian(at.iterate.trajectory, at.iterate.costates, out);
    };
  });
  add_benchmark(c, "roll_out", [](Evaluator& evaluator, const Case& at) {
    std::vector<double> steps(kLaneWidth, 1.0);
    for (int l = 1; l < kLaneWidth; ++l) steps[l] = steps[l - 1] / 2;
    Evaluation evaluation(at.problem());
    evaluator.evaluate(at.iterate.trajectory, evaluation);
    return
        [&evaluator, &at, steps, gap = evaluation.gap, out = LaneRollout(at.problem())]() mutable {
          evaluator.roll_out(at.iterate.trajectory, gap, at.iterate.feedback, steps.data(),
                             {.contract_gaps = true, .clamp_controls = true}, out);
        };
  });
  add_benchmark(c, "roll_out_alone", [](Evaluator& evaluator, const Case& at) {
    Evaluation evaluation(at.problem());
    evaluator.evaluate(at.iterate.trajectory, evaluation);
    return [&evaluator, &at, gap = evaluation.gap, out = SingleRollout(at.problem())]() mutable {
      evaluator.roll_out(at.iterate.trajectory, gap, at.iterate.feedback, 1.0,
                         {.contract_gaps = true, .clamp_controls = true}, out);
    };
  });
  add_part(c, "dynamics", [](const KnotModel& model, KnotBatch<Lane>& batch) {
    return [&model, &batch, data = std::shared_ptr(model.system().create_data(Lane()))] {
      model.system().differentiate(batch.x.data(), batch.u.data(), *data);
    };
  });
  add_part(c, "dynamics_and_gradients", [](const KnotModel& model, KnotBatch<Lane>& batch) {
    return [&model, &batch] { model.differentiate(batch.input(), batch.work, false); };
  });
  add_part(c, "dynamics_gradients_and_hessians",
           [](const KnotModel& model, KnotBatch<Lane>& batch) {
             return [&model, &batch] { model.differentiate(batch.input(), batch.work, true); };
           });
}

const bool kRegistered = [] {
  static const std::vector<std::unique_ptr<Case>> cases = load_cases();
  for (const auto& c : cases) add_case(*c);
  return true;
}();

}  // namespace
}  // namespace conddp
