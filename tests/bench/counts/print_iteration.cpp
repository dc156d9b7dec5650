// print_iteration CASE
//
// Prints one evaluation and one sweep of a counted problem, one named number a line.
// scripts/compare_paths compares them between the instruction sets that conddp is compiled for.
#include <cmath>
#include <cstdio>

#include "ocp/evaluation/evaluator.hpp"
#include "problems.hpp"
#include "solvers/riccati/backward_sweep.hpp"

namespace conddp {
namespace {

template <class Numbers>
void print(const char* name, int knot, const Numbers& numbers) {
  for (Eigen::Index j = 0; j < numbers.cols(); ++j)
    for (Eigen::Index i = 0; i < numbers.rows(); ++i)
      std::printf("%s[%d] %.17g\n", name, knot, numbers(i, j));
}

/// Moves away from the guess so that nothing is zero by chance: different controls and velocities.
Trajectory moved_guess(const ShootingProblem& problem) {
  Trajectory moved = problem.create_trajectory();
  const int nv = problem.nx() / 2;
  for (int k = 0; k < problem.knots(); ++k) {
    for (int i = 0; i < nv; ++i) moved.x(k + 1).tail(nv)[i] += 0.1 * std::sin(3.0 * k + i);
    for (int i = 0; i < problem.nu(k); ++i) moved.u(k)[i] += std::cos(2.0 * k + i);
  }
  return moved;
}

int run(const ShootingProblem& problem) {
  const Trajectory guess = moved_guess(problem);
  Evaluator evaluator(problem, 1);
  Evaluation evaluation(problem);
  evaluator.evaluate(guess, evaluation);
  print("cost", 0, evaluation.cost);
  print("gap", 0, evaluation.gap);

  Linearization linearization(problem);
  evaluator.differentiate(guess, linearization);
  for (int k = 0; k <= problem.knots(); ++k) {
    print("gradient", k, linearization.knots[k].gradient);
    print("hessian", k, linearization.knots[k].hessian());
    print("F", k, linearization.knots[k].F);
  }
  const ControlBounds bounds(problem);
  Gaps gaps(problem);
  gaps.set(linearization, true);
  Feedback feedback(problem);
  BackwardSweep sweep(problem, bounds);
  if (sweep.run(linearization, guess, gaps, {}, *unconstrained_stage(problem), feedback) >= 0)
    return 1;
  for (int k = 0; k < problem.knots(); ++k) {
    print("k", k, feedback.k[k]);
    print("K", k, feedback.K[k]);
    print("Vx", k, sweep.value(k).Vx);
    print("Vxx", k, sweep.value(k).Vxx);
  }
  return 0;
}

}  // namespace
}  // namespace conddp

int main(int argc, char** argv) {
  using namespace conddp;
  const auto& cases = counted_problems();
  const auto found = argc == 2 ? cases.find(argv[1]) : cases.end();
  if (found == cases.end()) {
    std::fprintf(stderr, "usage: print_iteration trot|reach|squat\n");
    return 2;
  }
  return run(found->second());
}
