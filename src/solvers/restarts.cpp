#include "solvers/restarts.hpp"

#include <limits>

#include <sys/wait.h>
#include <unistd.h>

#include "solvers/guess.hpp"

namespace conddp {
namespace {

/// The guess of a restart, 0: unchanged.
Trajectory start_of(const ShootingProblem& problem, const SolverOptions& options,
                    const Trajectory& guess, int restart) {
  if (restart == 0) return guess;
  const auto seed = static_cast<std::uint64_t>(options.restarts.seed) * 1000003 + restart;
  return perturb_guess(problem, guess, options.restarts.spread, seed);
}

struct Child {
  pid_t process = -1;
  int pipe = -1;
  int restart = 0;
};

/// The cost at which a solve converges, infinite if it does not; it runs in a child process.
Child begin(int restart, const std::function<double()>& run) {
  int ends[2];
  if (pipe(ends) != 0) return {};
  const pid_t process = fork();
  if (process == 0) {
    close(ends[0]);
    double cost = std::numeric_limits<double>::infinity();
    try {
      cost = run();
    } catch (...) {  // nothing may leave this process but a number
    }
    const bool written = write(ends[1], &cost, sizeof cost) == sizeof cost;
    _exit(written ? 0 : 1);
  }
  close(ends[1]);
  if (process > 0) return {process, ends[0], restart};
  close(ends[0]);
  return {};
}

double finish(const Child& child) {
  double cost = std::numeric_limits<double>::infinity();
  if (child.process < 0) return cost;
  double read_cost = 0;
  if (read(child.pipe, &read_cost, sizeof read_cost) == sizeof read_cost) cost = read_cost;
  close(child.pipe);
  waitpid(child.process, nullptr, 0);
  return cost;
}

}  // namespace

Trajectory best_start(const ShootingProblem& problem, const SolverOptions& options,
                      const Trajectory& guess,
                      const std::function<SolveResult(const Trajectory&)>& solve) {
  int best = 0;
  double least = std::numeric_limits<double>::infinity();
  std::vector<Child> running;
  const auto wait_for_first = [&] {
    const Child child = running.front();
    running.erase(running.begin());
    const double cost = finish(child);
    if (cost >= least) return;
    least = cost;
    best = child.restart;
  };
  for (int i = 0; i <= options.restarts.count; ++i) {
    if (static_cast<int>(running.size()) == options.threads) wait_for_first();
    running.push_back(begin(i, [&] {
      const SolveResult result = solve(start_of(problem, options, guess, i));
      return result.status == SolveStatus::converged ? result.cost
                                                     : std::numeric_limits<double>::infinity();
    }));
  }
  while (!running.empty()) wait_for_first();
  return start_of(problem, options, guess, best);
}

}  // namespace conddp
