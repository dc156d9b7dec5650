#include "analysis/comparison/random_instance.hpp"

#include <algorithm>
#include <random>

#include "solvers/common/guess.hpp"
#include "systems/initial_choice.hpp"
#include "systems/system.hpp"

namespace conddp {

ShootingProblem perturb_initial_state(const ShootingProblem& problem, double size,
                                      std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  const KnotModel& model = *problem.knot(0).model;
  const bool is_choice = problem.phases().front().instant;
  const int own = model.system().ndx();
  std::vector<double> dx(problem.ndx(), 0.0);
  for (int i = 0; i < own; ++i) dx[i] = size * (static_cast<double>(engine() >> 11) * 0x1p-52 - 1);
  // Free coordinates of the initial state stay as they are.
  if (is_choice)
    for (const int i : chosen_coordinates(model.system())) dx[i] = 0;
  // The time starts as before, and coordinates that do not move yet stay at rest.
  for (const int i : other_coordinates(model.system())) dx[i] = 0;
  std::vector<double> x0 = problem.initial_state();
  const bool moves = std::ranges::any_of(dx, [](double entry) { return entry != 0; });
  if (moves)  // a move by zero would round
    problem.manifold().integrate(x0.data(), dx.data(), x0.data());
  return {std::move(x0), problem.phases(), problem.terminal()};
}

ProblemPath perturb_initial_state(ProblemPath homotopy, double size, std::uint64_t seed) {
  if (!homotopy || size == 0) return homotopy;
  return [=](double share) -> std::shared_ptr<const ShootingProblem> {
    const auto problem = homotopy(share);
    if (!problem) return nullptr;
    return std::make_shared<const ShootingProblem>(perturb_initial_state(*problem, size, seed));
  };
}

Trajectory guess_of_instance(const ShootingProblem& instance, const Trajectory& guess,
                             const Perturbation& perturbation) {
  // A perturbation of zero would round, and draw numbers in vain.
  Trajectory start = perturbation.guess == 0
                         ? guess
                         : perturb_guess(instance, guess, perturbation.guess, perturbation.seed);
  start.x(0) = Eigen::Map<const Eigen::VectorXd>(instance.initial_state().data(), instance.nx());
  return start;
}

}  // namespace conddp
