#include "solvers/strategies/option_check.hpp"

#include <stdexcept>

#include <fmt/format.h>

namespace conddp {
namespace {

/// Why multipliers are not those of a problem of this shape, if so.
std::optional<std::string> misfit(const ShootingProblem& problem, const DualGuess& guess) {
  const int N = problem.knots();
  bool fits =
      guess.constraints.size() == problem.constraint_rows() &&
      (guess.costates.size() == 0 ||
       (guess.costates.rows() == problem.ndx() && guess.costates.cols() == N + 1)) &&
      (guess.control_gradient.empty() || static_cast<int>(guess.control_gradient.size()) == N);
  for (std::size_t k = 0; fits && k < guess.control_gradient.size(); ++k)
    fits = guess.control_gradient[k].size() == problem.nu(static_cast<int>(k));
  if (fits) return std::nullopt;
  return "the multipliers to start from do not have the shape of the problem";
}

/// Why the solver cannot take the problem with these options, if so.
std::optional<std::string> unsupported_options(const SolverInfo& solver,
                                               const ShootingProblem& problem,
                                               const SolverOptions& options) {
  std::string wrong;
  for (const std::string& message : options.validate()) {
    if (!wrong.empty()) wrong += "; ";
    wrong += message;
  }
  if (!wrong.empty()) return wrong;
  if (auto reason = unsupported(solver, problem)) return reason;
  if (options.hessian == HessianChoice::exact && !solver.exact_hessian)
    return fmt::format("hessian: {} has no exact Hessian", solver.name);
  if (options.hessian == HessianChoice::gauss_newton && !solver.gauss_newton_hessian)
    return fmt::format("hessian: {} always uses the exact one", solver.name);
  if (auto reason = unsupported_segments(solver, problem, options.legs)) return reason;
  if (options.multipliers) return misfit(problem, *options.multipliers);
  return std::nullopt;
}

}  // namespace

void check_options(const SolverInfo& solver, const ShootingProblem& problem,
                   const SolverOptions& options) {
  if (const auto reason = unsupported_options(solver, problem, options))
    throw std::invalid_argument(*reason);
}

}  // namespace conddp
