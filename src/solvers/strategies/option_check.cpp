#include "solvers/strategies/option_check.hpp"

#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace conddp {
namespace {

bool costates_fit(const ShootingProblem& problem, const Eigen::MatrixXd& costates) {
  return costates.size() == 0 ||
         (costates.rows() == problem.ndx() && costates.cols() == problem.knots() + 1);
}

bool control_gradient_fits(const ShootingProblem& problem,
                           const std::vector<Eigen::VectorXd>& gradient) {
  if (gradient.empty()) return true;
  if (static_cast<int>(gradient.size()) != problem.knots()) return false;
  for (int k = 0; k < problem.knots(); ++k)
    if (gradient[k].size() != problem.nu(k)) return false;
  return true;
}

/// Reason why multipliers do not have the shape of the problem, if any.
std::optional<std::string> misfit(const ShootingProblem& problem, const DualGuess& guess) {
  if (guess.constraints.size() == problem.constraint_rows() &&
      costates_fit(problem, guess.costates) &&
      control_gradient_fits(problem, guess.control_gradient))
    return std::nullopt;
  return "the multipliers to start from do not have the shape of the problem";
}

/// Reason why the solver does not support the problem with these options, if any.
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
