#include "solvers/strategies/option_check.hpp"

#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

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

std::optional<std::string> unsupported_hessian(const SolverInfo& solver, HessianChoice choice) {
  if (choice == HessianChoice::exact && !solver.exact_hessian)
    return fmt::format("hessian: {} has no exact Hessian", solver.name);
  if (choice == HessianChoice::gauss_newton && !solver.gauss_newton_hessian)
    return fmt::format("hessian: {} always uses the exact one", solver.name);
  return std::nullopt;
}

/// Why the solver cannot take the problem with these options, if so.
std::optional<std::string> unsupported_options(const SolverInfo& solver,
                                               const ShootingProblem& problem,
                                               const SolverOptions& options) {
  if (const std::vector<std::string> wrong = options.validate(); !wrong.empty())
    return fmt::format("{}", fmt::join(wrong, "; "));
  if (auto reason = unsupported(solver, problem)) return reason;
  if (auto reason = unsupported_hessian(solver, options.hessian)) return reason;
  if (auto reason = unsupported_segments(solver, problem, options.segments)) return reason;
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
