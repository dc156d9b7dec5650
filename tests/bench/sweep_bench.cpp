// The Riccati sweep, knot by knot, at the sizes of an arm, a quadruped, and a humanoid with
// semi-implicit Euler; the last two have a floating base. The quadratic models are random because
// their values do not affect the time.
#include <benchmark/benchmark.h>

#include "solvers/linalg/lane_gemm.hpp"
#include "solvers/riccati/backward_sweep.hpp"
#include "solvers/stages/stage_solver.hpp"
#include "support/random_numbers.hpp"
#include "systems/closed_form.hpp"

namespace conddp {
namespace {

/// Masses with forces on the last nu coordinates; the first six coordinates may be a rigid
/// placement.
class Masses : public ClosedFormSystem<Masses> {
 public:
  Masses(bool floating, int nv, int nu)
      : ClosedFormSystem(SystemKind::second_order, product(floating, nv), nu) {}

  template <class S>
  void rate(const S*, const S* u, S* f) const {
    for (int i = 0; i < nv(); ++i) f[i] = i < nv() - nu() ? S(0.0) : u[i - nv() + nu()];
  }

 private:
  static StateManifold product(bool floating, int nv) {
    StateManifold m;
    if (floating) m.append(StateManifold::Part::se3);
    m.append(StateManifold::Part::flat, floating ? 2 * nv - 6 : 2 * nv);
    return m;
  }
};

struct Size {
  const char* name;
  bool floating;
  int nv, nu;
};
constexpr Size kSizes[] = {
    {"arm", false, 7, 7}, {"quadruped", true, 18, 12}, {"humanoid", true, 38, 32}};
constexpr int kKnots = 20;

Eigen::MatrixXd random_matrix(RandomNumbers& random, int rows, int cols) {
  return Eigen::MatrixXd::NullaryExpr(rows, cols, [&] { return random.uniform(-1, 1); });
}

/// I + A Aᵀ.
Eigen::MatrixXd random_definite(RandomNumbers& random, int n) {
  const Eigen::MatrixXd A = random_matrix(random, n, n);
  return Eigen::MatrixXd::Identity(n, n) + A * A.transpose() / n;
}

ShootingProblem problem_of(const Size& size, int count = kKnots) {
  const auto system = std::make_shared<Masses>(size.floating, size.nv, size.nu);
  const auto phase = [&](Integrator integrator, int knots) {
    return Phase{.name = "all",
                 .model = std::make_shared<KnotModel>(system, integrator),
                 .dt = std::vector<double>(knots, 0.01),
                 .cost_scale = std::vector<double>(knots, 0.01),
                 .parameters = {}};
  };
  return ShootingProblem(system->manifold().neutral(),
                         {phase(Integrator::semi_implicit_euler, count)},
                         phase(Integrator::none, 1));
}

Linearization linearization_of(const ShootingProblem& problem) {
  RandomNumbers random(1);
  Linearization all(problem);
  for (KnotLinearization& knot : all.knots) {
    const int nz = static_cast<int>(knot.gradient.size());
    const int rows = static_cast<int>(knot.F.rows());
    knot.gradient = random_matrix(random, nz, 1);
    knot.hessian.change() = random_definite(random, nz);
    if (rows == 0) continue;
    knot.F = 0.3 * random_matrix(random, rows, nz) / std::sqrt(rows);
    for (std::size_t s = 0; s < knot.curved.size(); ++s) {
      knot.A[s] = Eigen::Matrix<double, 6, 6>::Identity() + 0.1 * random_matrix(random, 6, 6);
      knot.H[s] = Eigen::Matrix<double, 6, 6>::Identity() + 0.1 * random_matrix(random, 6, 6);
    }
  }
  return all;
}

void count_knots(benchmark::State& state, int knots) {
  state.counters["knot"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * knots,
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

/// The whole sweep: propagation, stage, and value.
void sweep(benchmark::State& state) {
  const ShootingProblem problem = problem_of(kSizes[state.range(0)]);
  const Linearization linearization = linearization_of(problem);
  const ControlBounds bounds(problem);
  const Trajectory trajectory = problem.create_trajectory();
  const auto policy = unconstrained_stage(problem);
  BackwardSweep backward(problem, bounds);
  Feedback feedback(problem);
  const Gaps gaps(problem);  // no gaps
  for (auto _ : state) {
    if (backward.run(linearization, trajectory, gaps, {}, *policy, feedback) >= 0) {
      state.SkipWithError("a stage has no minimum");
      break;
    }
    benchmark::DoNotOptimize(feedback.k.front().data());
  }
  state.SetLabel(kSizes[state.range(0)].name);
  count_knots(state, kKnots);
}
BENCHMARK(sweep)->DenseRange(0, 2);

/// Propagation of the value through the dynamics only.
void propagation(benchmark::State& state) {
  const ShootingProblem problem = problem_of(kSizes[state.range(0)]);
  const Linearization linearization = linearization_of(problem);
  const KnotLinearization& knot = linearization.knots.front();
  const int ndx = problem.ndx(), nu = problem.nu(0);
  ValueFunction value(ndx);
  RandomNumbers random(2);
  value.Vxx = random_definite(random, ndx);
  ValuePropagation propagate(ndx, nu);
  ActionValue q(ndx, nu);
  for (auto _ : state) {
    propagate.propagate(knot, value, q);
    benchmark::DoNotOptimize(q.Qzz().data());
    benchmark::ClobberMemory();
  }
  state.SetLabel(kSizes[state.range(0)].name);
  count_knots(state, 1);
}
BENCHMARK(propagation)->DenseRange(0, 2);

/// Products C = A B of the occurring sizes, ours and Eigen's: A is m x k, B is k x n.
void product(benchmark::State& state, bool lanes, bool lower) {
  const int m = static_cast<int>(state.range(0)), k = static_cast<int>(state.range(1));
  const int n = lower ? m : static_cast<int>(state.range(2));
  RandomNumbers random(3);
  const Eigen::MatrixXd A = random_matrix(random, m, k), B = random_matrix(random, k, n);
  LaneMatrix lanes_A(m, k), lanes_C(m, n);
  lanes_A.view() = A;
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(m, n);
  for (auto _ : state) {
    if (lanes && lower) {
      multiply_lower(Store::set, lanes_C.block(), lanes_A.block(), Factor::of_eigen(B));
    } else if (lanes) {
      multiply(Store::set, lanes_C.block(), lanes_A.block(), Factor::of_eigen(B));
    } else if (lower) {
      C.triangularView<Eigen::Lower>() = A * B;
    } else {
      C.noalias() = A * B;
    }
    benchmark::DoNotOptimize(C.data());
    benchmark::DoNotOptimize(lanes_C.data());
    benchmark::ClobberMemory();
  }
  const double flops = lower ? static_cast<double>(m) * (m + 1) * k : 2.0 * m * k * n;
  state.counters["FLOP"] = benchmark::Counter(static_cast<double>(state.iterations()) * flops,
                                              benchmark::Counter::kIsRate);
}

void sizes(benchmark::internal::Benchmark* benchmark) {
  benchmark->Args({21, 7, 7})->Args({48, 18, 18})->Args({108, 38, 38})->Args({48, 36, 36});
}
BENCHMARK_CAPTURE(product, eigen, false, false)->Apply(sizes);
BENCHMARK_CAPTURE(product, lanes, true, false)->Apply(sizes);

void square_sizes(benchmark::internal::Benchmark* benchmark) {
  benchmark->Args({21, 7})->Args({48, 18})->Args({108, 38});
}
BENCHMARK_CAPTURE(product, eigen_lower, false, true)->Apply(square_sizes);
BENCHMARK_CAPTURE(product, lanes_lower, true, true)->Apply(square_sizes);

}  // namespace
}  // namespace conddp
