#include "solvers/strategies/reusable_solver.hpp"

#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "solvers/ddp/ddp_solver.hpp"
#include "solvers/ddp/family.hpp"
#include "solvers/interior/interior_solver.hpp"

namespace conddp {

ReusableSolver::ReusableSolver(const ShootingProblem& problem, std::string_view solver,
                               const SolverOptions& options,
                               std::shared_ptr<EvaluationMemory> memory) {
  const SolverInfo* info = find_solver(solver);
  if (info == nullptr) throw std::invalid_argument(fmt::format("unknown solver '{}'", solver));
  if (options.restarts.count > 0 || options.homotopy)
    throw std::invalid_argument("a solver that is used again has no restarts and no homotopy");
  check_options(*info, problem, options);
  SolverOptions own = options;
  if (info->constraints != ConstraintSupport::all) own.multipliers = nullptr;
  if (const DdpMember* member = find_ddp_member(solver)) {
    solver_ = std::make_unique<DdpSolver>(problem, member->recipe, own, std::move(memory));
    solver_->reserve_exact_hessians();
  } else {
    if (info->real_time) ticks_ = std::make_unique<InteriorSolver>(problem, own, std::move(memory));
    anew_ = [info, &problem, own](const Trajectory& guess) {
      return info->run(problem, own, guess);
    };
  }
}

ReusableSolver::~ReusableSolver() = default;

const SolveResult& ReusableSolver::solve(const Trajectory& guess) {
  if (solver_) return solver_->solve(guess);
  answer_ = anew_(guess);
  return *answer_;
}

const SolveResult& ReusableSolver::iterate(const Trajectory& guess) {
  if (solver_) return solver_->solve(guess, LastIterate::evaluated);
  if (!ticks_) throw std::logic_error("the solver has no real-time iteration");
  answer_.reset();
  return ticks_->iterate(guess);
}

void ReusableSolver::take_feedback(Feedback& to) {
  if (solver_)
    solver_->take_feedback(to);
  else if (answer_)
    std::swap(answer_->feedback, to);
  else
    ticks_->take_feedback(to);
}

void ReusableSolver::exchange_memory(ReusableSolver& other) {
  if (solver_ && other.solver_) solver_->exchange_memory(*other.solver_);
}

}  // namespace conddp
