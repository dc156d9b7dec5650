#include "solvers/strategies/reusable_solver.hpp"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>

#include "solvers/ddp/ddp_solver.hpp"
#include "solvers/ddp/family.hpp"
#include "solvers/strategies/option_check.hpp"

namespace conddp {

ReusableSolver::ReusableSolver(const ShootingProblem& problem, std::string_view solver,
                               const SolverOptions& options) {
  const auto family = ddp_family();
  const auto member = std::find_if(family.begin(), family.end(),
                                   [&](const DdpMember& known) { return known.name == solver; });
  if (member == family.end())
    throw std::invalid_argument(fmt::format("no solver of the DDP family is named '{}'", solver));
  if (options.restarts.count > 0 || options.homotopy)
    throw std::invalid_argument("a solver that is used again has no restarts and no homotopy");
  const SolverInfo& info = *find_solver(solver);
  check_options(info, problem, options);
  SolverOptions own = options;
  if (info.constraints != ConstraintSupport::all) own.multipliers = nullptr;
  solver_ = std::make_unique<DdpSolver>(problem, member->recipe, own);
  solver_->reserve_exact_hessians();
}

ReusableSolver::~ReusableSolver() = default;

const SolveResult& ReusableSolver::solve(const Trajectory& guess) { return solver_->solve(guess); }

const SolveResult& ReusableSolver::iterate(const Trajectory& guess) {
  return solver_->solve(guess, LastIterate::evaluated);
}

}  // namespace conddp
