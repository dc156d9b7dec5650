#include "batch/run/refined_solve.hpp"

#include <algorithm>
#include <chrono>
#include <string>

#include <fmt/format.h>

#include "analysis/certificate/certificate_doubt.hpp"
#include "solvers/strategies/feasible_guess.hpp"

namespace conddp {
namespace {

constexpr double kLeastTime = 1e-3;  // s

Setting setting_of_grid(int factor) {
  return make_setting({"mesh.factor", {}},
                      {.kind = YamlNode::Kind::kScalar, .text = std::to_string(factor)});
}

}  // namespace

RefinedSolve refine(const ProblemInstance& first, const SolveResult& result,
                    const std::vector<const SolverInfo*>& candidates, SolverOptions options,
                    const BuildOnGrid& build, const SolverInfo*& solver) {
  RefinedSolve refined{.result = result};
  const auto began = std::chrono::steady_clock::now();
  const double most = options.max_time_s;
  options = options_near(options);
  options.restarts.count = 0;
  options.homotopy = nullptr;
  options.multipliers = nullptr;
  MeshRefinement mesh(*first.spec);
  const ProblemInstance* grid = &first;
  while (const auto factor = mesh.next(*grid->built.problem, refined.result)) {
    auto finer = build(setting_of_grid(*factor));
    if (!finer) break;
    finer->built.guess =
        on_grid(*grid->built.problem, refined.result.trajectory, *finer->built.problem);
    finer->built.guess_used = first.built.guess_used;
    const std::chrono::duration<double> gone = std::chrono::steady_clock::now() - began;
    options.max_time_s = std::max(kLeastTime, most - gone.count());
    refined.result = solve(*finer->built.problem, candidates, options, finer->built.guess, solver,
                           certificate_doubt(options));
    refined.instance = std::move(finer);
    grid = &*refined.instance;
  }
  refined.rounds = mesh.rounds();
  refined.setting = setting_of_grid(refined.rounds.back().factor).text;
  return refined;
}

std::string too_coarse(const RefinedSolve& solve, const ProblemSpec& spec) {
  const double error = solve.rounds.back().error, asked = spec.mesh->error;
  if (error <= asked) return {};
  return fmt::format("the last grid of {} knots has an error of {:.1e}, which is more than {:.1e}",
                     solve.rounds.back().knots, error, asked);
}

}  // namespace conddp
