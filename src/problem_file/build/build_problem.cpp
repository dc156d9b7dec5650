#include "problem_file/build/build_problem.hpp"

#include "problem_file/build/homotopy.hpp"

namespace conddp {

std::optional<BuiltProblem> build_problem(const ProblemSpec& spec, const BuildOptions& options,
                                          Diagnostics& out) {
  auto built = build_without_homotopy(spec, options, out);
  if (!built || spec.solver.homotopy.empty()) return built;
  built->homotopy = Homotopy::build(spec, options, *built->problem, out);
  if (!built->homotopy) return std::nullopt;
  return built;
}

}  // namespace conddp
