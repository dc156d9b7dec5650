#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "solvers/common/control_bounds.hpp"
#include "solvers/common/feasible.hpp"
#include "solvers/common/tuning.hpp"
#include "solvers/strategies/joined_solves.hpp"
#include "solvers/strategies/strategies.hpp"

namespace conddp {
namespace {

SolverOptions::Tolerances tightened(SolverOptions::Tolerances t, double share) {
  for (double* tolerance : {&t.stationarity, &t.gap, &t.constraint, &t.complementarity})
    *tolerance *= share;
  return t;
}

/// Options of a solve near an answer. It starts from the answer's multipliers. The first epsilon of
/// complementary pairs is the geometric mean of the usual first and last ones: larger values lead
/// away from the answer.
SolverOptions from_answer(const SolveResult& answer, SolverOptions options) {
  options.multipliers = std::make_shared<const DualGuess>(
      DualGuess{answer.constraint_multipliers, answer.costates, answer.control_gradient});
  double& epsilon = options.complementarity.initial;
  epsilon = std::sqrt(epsilon * SolverOptions::Complementarity::kLast);
  return options;
}

/// The Lagrangian of a trajectory near an answer, with the answer's multipliers.
class Lagrangian {
 public:
  Lagrangian(const ShootingProblem& problem, const SolveResult& answer)
      : problem_(problem), answer_(answer), evaluator_(problem), values_(problem) {}

  double at(const Trajectory& trajectory) {
    evaluator_.evaluate(trajectory, values_);
    double sum = values_.cost.sum() + answer_.constraint_multipliers.dot(values_.constraint);
    for (int k = 0; k < problem_.knots(); ++k)
      sum += answer_.costates.col(k + 1).dot(values_.gap.col(k));
    return std::isfinite(sum) ? sum : std::numeric_limits<double>::infinity();
  }

 private:
  const ShootingProblem& problem_;
  const SolveResult& answer_;
  Evaluator evaluator_;
  Evaluation values_;
};

Trajectory moved(const ShootingProblem& problem, const Trajectory& from,
                 const std::vector<Eigen::VectorXd>& direction, double length) {
  Trajectory to = from;
  const ControlBounds bounds(problem);
  Eigen::VectorXd z;
  for (int k = 0; k <= problem.knots(); ++k) {
    z = length * direction[k];
    problem.manifold().integrate(from.x(k).data(), z.data(), to.x(k).data());
    if (k < problem.knots()) to.u(k) += z.tail(problem.nu(k));
  }
  bounds.clamp(to);
  return to;
}

/// Lowest of a few points along a descent direction, one for each sign; the lower one first, and
/// the direction's own sign if both are similar.
std::array<Trajectory, 2> along_descent(const ShootingProblem& problem, const SolveResult& answer,
                                        const std::vector<Eigen::VectorXd>& direction) {
  Lagrangian lagrangian(problem, answer);
  const double here = lagrangian.at(answer.trajectory);
  std::array<Trajectory, 2> best{answer.trajectory, answer.trajectory};
  std::array<double, 2> lowest{here, here};
  for (const int way : {0, 1}) {
    double length = way == 0 ? 1 : -1;
    for (int i = 0; i < tuning::kTries; ++i, length /= 2) {
      Trajectory trial = moved(problem, answer.trajectory, direction, length);
      const double value = lagrangian.at(trial);
      if (!(value < lowest[way])) continue;
      lowest[way] = value;
      best[way] = std::move(trial);
    }
  }
  if (here - lowest[1] > (1 + tuning::kMostGain) * (here - lowest[0])) std::swap(best[0], best[1]);
  return best;
}

/// True if an answer with another status still meets all tolerances.
bool is_answer(const SolveResult& result, const SolverOptions& options) {
  const Residuals& r = result.residuals;
  switch (result.status) {
    case SolveStatus::converged:
      return true;
    case SolveStatus::line_search_failed:
    case SolveStatus::regularization_limit:
    case SolveStatus::max_iterations:
      return r.stationarity <= options.tolerances.stationarity &&
             is_feasible(r, options.tolerances);
    default:
      return false;
  }
}

/// Makes a further answer the overall answer.
void take(SolveResult next, const Objection& objection, JoinedSolves& solves, SolveResult& result) {
  solves.add(next);
  next.status = SolveStatus::converged;
  next.message = fmt::format("{}; the answer before: {}", next.message, objection.text);
  result = std::move(next);
}

/// Solves from points on both sides of a saddle. False if neither leads to a cheaper answer.
bool leave_saddle(const ShootingProblem& problem, const SolverOptions& options,
                  JoinedSolves& solves, const Objection& objection, const SolveFrom& solve,
                  SolveResult& result) {
  for (const Trajectory& start : along_descent(problem, result, objection.descent)) {
    SolveResult next = solve(from_answer(result, solves.next()), start);
    if (!is_answer(next, options) || !(next.cost < result.cost)) continue;
    take(std::move(next), objection, solves, result);
    return true;
  }
  return false;
}

}  // namespace

SolveResult solve_answering(const ShootingProblem& problem, const SolverOptions& options,
                            const Trajectory& guess, const Doubt& doubt, Objection& remaining,
                            const SolveFrom& solve) {
  remaining = {};
  JoinedSolves solves(options);
  SolveResult result = solve(solves.next(), guess);
  if (!doubt || result.status != SolveStatus::converged) return result;
  solves.add(result);
  remaining = doubt(problem, result);
  double share = 1;
  const int most = std::max(tuning::kTries, result.iterations);
  for (int round = 0; round < tuning::kRounds && solves.iterations_left() > 0; ++round) {
    const double before = remaining.excess;
    // Curvature along which nothing is lower belongs to an active set that is not settled.
    if (!remaining.descent.empty() &&
        leave_saddle(problem, options, solves, remaining, solve, result)) {
      remaining = doubt(problem, result);
      continue;
    }
    if (!(before > 1) || remaining.of_problem) break;
    share = std::max(tuning::kLeastGoal, share * tuning::kGoalMargin / std::sqrt(before));
    SolverOptions own = from_answer(result, solves.next());
    own.tolerances = tightened(options.tolerances, share);
    if (before <= tuning::kExcess) own.max_iterations = std::min(own.max_iterations, most);
    SolveResult next = solve(own, result.trajectory);
    if (!is_answer(next, options)) break;
    take(std::move(next), remaining, solves, result);
    remaining = doubt(problem, result);
    if (!(remaining.excess < tuning::kProgress * before)) break;
  }
  return solves.answer(std::move(result));
}

}  // namespace conddp
