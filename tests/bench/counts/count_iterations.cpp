// count_iterations CASE [--burn N]
//
// The program that scripts/count_instructions measures. A solver runs a fixed number of iterations
// on one of a few small problems. The program links few sources and therefore compiles quickly.
// --burn adds N rounds of work to every iteration, which the check must detect.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <string>
#include <string_view>

#include "problems.hpp"
#include "solvers/ddp/ddp_solver.hpp"
#include "solvers/ddp/family.hpp"

namespace conddp {
namespace {

/// Solver and number of iterations for the problem of this name.
struct Case {
  std::string_view problem;
  std::string_view solver;
  int iterations;
  HessianUse hessian = HessianUse::gauss_newton;
};
constexpr Case kCases[] = {{"trot", "box_fddp", 6},
                           {"reach", "box_fddp", 6},
                           {"squat", "box_fddp", 6},
                           {"swing", "altro", 20},
                           {"flight", "box_fddp", 6, HessianUse::exact},
                           {"grip", "altro", 10}};

DdpRecipe recipe_of(const Case& counted) {
  const auto family = ddp_family();
  DdpRecipe recipe = std::ranges::find(family, counted.solver, &DdpMember::name)->recipe;
  recipe.hessian = counted.hessian;
  return recipe;
}

/// Work that the compiler cannot optimize away.
void burn(long rounds) {
  volatile long sum = 0;
  for (long i = 0; i < rounds; ++i) sum = sum + i;
}

int run(const Case& counted, long rounds) {
  const ShootingProblem problem = counted_problems().at(std::string(counted.problem))();
  SolverOptions options;
  options.max_iterations = counted.iterations;
  options.tolerances.stationarity = options.tolerances.gap = 0;
  options.on_iteration = [rounds](const IterationRecord&) { burn(rounds); };
  DdpSolver solver(problem, recipe_of(counted), options);
  const SolveResult& result = solver.solve(problem.create_trajectory());
  std::printf("{\"iterations\": %d, \"knots\": %d, \"cost\": %.10g}\n", result.iterations,
              problem.knots(), result.cost);
  return result.iterations == counted.iterations ? 0 : 1;
}

}  // namespace
}  // namespace conddp

int main(int argc, char** argv) {
  using namespace conddp;
  const bool burns = argc == 4 && std::strcmp(argv[2], "--burn") == 0;
  const std::string_view name = argc == 2 || burns ? argv[1] : "";
  const Case* found = std::ranges::find(kCases, name, &Case::problem);
  if (found == std::end(kCases)) {
    std::fprintf(stderr, "usage: count_iterations trot|reach|squat|swing|flight|grip [--burn N]\n");
    return 2;
  }
  return run(*found, burns ? std::atol(argv[3]) : 0);
}
