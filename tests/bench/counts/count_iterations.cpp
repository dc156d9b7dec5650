// count_iterations CASE [--burn N]
//
// Solves one of three small problems with box_fddp's recipe for a fixed number of iterations: what
// scripts/count_instructions counts. It links few sources, so that it is soon compiled. --burn
// wastes N rounds of work in every iteration, which the check has to notice.
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "problems.hpp"
#include "solvers/ddp/ddp_solver.hpp"

namespace conddp {
namespace {

constexpr int kIterations = 6;

/// Work that the compiler cannot leave out.
void burn(long rounds) {
  volatile long sum = 0;
  for (long i = 0; i < rounds; ++i) sum = sum + i;
}

int run(const ShootingProblem& problem, long rounds) {
  SolverOptions options;
  options.max_iterations = kIterations;
  options.tolerances.stationarity = options.tolerances.gap = 0;
  options.on_iteration = [rounds](const IterationRecord&) { burn(rounds); };
  DdpSolver solver(problem,
                   {.open_gaps = true,
                    .clamp_controls = true,
                    .box_stage = true,
                    .hessian = HessianUse::gauss_newton},
                   options);
  const SolveResult& result = solver.solve(problem.create_trajectory());
  std::printf("{\"iterations\": %d, \"knots\": %d, \"cost\": %.10g}\n", result.iterations,
              problem.knots(), result.cost);
  return result.iterations == kIterations ? 0 : 1;
}

}  // namespace
}  // namespace conddp

int main(int argc, char** argv) {
  using namespace conddp;
  const auto& cases = counted_problems();
  const bool burns = argc == 4 && std::strcmp(argv[2], "--burn") == 0;
  const auto found = argc == 2 || burns ? cases.find(argv[1]) : cases.end();
  if (found == cases.end()) {
    std::fprintf(stderr, "usage: count_iterations trot|reach|squat [--burn N]\n");
    return 2;
  }
  return run(found->second(), burns ? std::atol(argv[3]) : 0);
}
