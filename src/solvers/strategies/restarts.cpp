#include "solvers/strategies/restarts.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <map>
#include <mutex>
#include <thread>

#include "solvers/common/guess.hpp"

namespace conddp {
namespace {

/// Costs that differ by less than this share of them are equal.
constexpr double kEqualCost = 1e-6;
/// Trajectories that differ by less than this share of how far they lead are equal: where a cost is
/// flat to kEqualCost, states are known to about its square root.
constexpr double kEqualStates = 1e-2;

bool equal_costs(double a, double b) {
  return std::abs(a - b) <= kEqualCost * std::max(std::abs(a), std::abs(b));
}

/// The largest entry of x_k ⊖ y_k over all nodes; y of one node alone is its state throughout.
template <class Other>
double distance(const ShootingProblem& problem, const Trajectory& x, const Other& y) {
  Eigen::VectorXd dx(problem.ndx());
  double largest = 0;
  for (int k = 0; k <= problem.knots(); ++k) {
    problem.manifold().difference(y(k).data(), x.x(k).data(), dx.data());
    largest = std::max(largest, dx.lpNorm<Eigen::Infinity>());
  }
  return largest;
}

bool equal_trajectories(const ShootingProblem& problem, const Trajectory& a, const Trajectory& b) {
  const double extent = distance(problem, a, [&](int) { return a.x(0); });
  return distance(problem, a, [&](int k) { return b.x(k); }) <= kEqualStates * extent;
}

/// The guess of a start, 0: unchanged.
Trajectory start_of(const ShootingProblem& problem, const SolverOptions& options,
                    const Trajectory& guess, int start) {
  if (start == 0) return guess;
  const auto seed = static_cast<std::uint64_t>(options.restarts.seed) * 1000003 + start;
  return perturb_guess(problem, guess, options.restarts.spread, seed);
}

struct Outcome {
  std::optional<SolveResult> result;  ///< none of a start that was not made
  const SolverInfo* used = nullptr;
  std::exception_ptr failure;
};

/// Takes outcomes in the order of their starts, whatever the order in which they come.
class Collector {
 public:
  explicit Collector(const ShootingProblem& problem) : problem_(problem) {}

  void add(int start, Outcome outcome) {
    waiting_.emplace(start, std::move(outcome));
    for (auto next = waiting_.find(next_); next != waiting_.end(); next = waiting_.find(next_)) {
      take(next->second);
      waiting_.erase(next);
      ++next_;
    }
  }

  SolveResult answer(const SolverInfo*& used) {
    if (failure_) std::rethrow_exception(failure_);
    std::vector<Basin> basins;
    for (Optimum& optimum : optima_) basins.push_back(optimum.basin);
    std::stable_sort(basins.begin(), basins.end(),
                     [](const Basin& a, const Basin& b) { return a.cost < b.cost; });
    record_.basins = std::move(basins);
    used = best_.used;
    best_.result->restarts = std::move(record_);
    return *std::move(best_.result);
  }

 private:
  struct Optimum {
    Basin basin;
    Trajectory trajectory;
  };

  void take(Outcome& outcome) {
    if (outcome.failure && !failure_) failure_ = outcome.failure;
    if (!outcome.result) return;
    ++record_.starts;
    const SolveResult& result = *outcome.result;
    const bool converged = is_success(result.status);
    if (converged) {
      ++record_.converged;
      count(result);
    }
    const bool better =
        !best_.result ||
        (converged &&
         (!is_success(best_.result->status) ||
          (result.cost < best_.result->cost && !equal_costs(result.cost, best_.result->cost))));
    if (!better) return;
    record_.answer = next_;
    best_ = std::move(outcome);
  }

  void count(const SolveResult& result) {
    const auto same = std::find_if(optima_.begin(), optima_.end(), [&](const Optimum& optimum) {
      return equal_costs(optimum.basin.cost, result.cost) &&
             equal_trajectories(problem_, optimum.trajectory, result.trajectory);
    });
    if (same != optima_.end()) {
      ++same->basin.starts;
      return;
    }
    optima_.push_back({{.cost = result.cost, .starts = 1, .first = next_}, result.trajectory});
  }

  const ShootingProblem& problem_;
  std::map<int, Outcome> waiting_;
  int next_ = 0;
  Outcome best_;
  std::vector<Optimum> optima_;
  RestartRecord record_;
  std::exception_ptr failure_;
};

}  // namespace

SolveResult solve_restarts(const ShootingProblem& problem, const SolverOptions& options,
                           const Trajectory& guess, int threads, const Solve& solve,
                           const SolverInfo*& used) {
  const auto began = std::chrono::steady_clock::now();
  const auto gone = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  };
  const int starts = options.restarts.count + 1;
  threads = std::min(threads, starts);
  std::mutex callbacks, results;
  bool interrupted = false;  // guarded by `callbacks`
  const auto ask = [&] {
    const std::lock_guard lock(callbacks);
    return interrupted = interrupted || (options.interrupted && options.interrupted());
  };
  SolverOptions own = options;
  own.restarts = {};
  if (threads > 1) own.threads = 1;
  own.interrupted = ask;
  Collector collector(problem);

  const auto make = [&](int start) {
    Outcome outcome;
    try {
      SolverOptions mine = own;
      mine.on_iteration = nullptr;
      if (start == 0 && options.on_iteration)
        mine.on_iteration = [&](const IterationRecord& row) {
          const std::lock_guard lock(callbacks);
          options.on_iteration(row);
        };
      if (start > 0) mine.max_time_s = options.max_time_s - gone();
      if (start == 0 || (mine.max_time_s > 0 && !ask()))
        outcome.result = solve(start_of(problem, options, guess, start), mine, outcome.used);
    } catch (...) {
      outcome.failure = std::current_exception();
    }
    const std::lock_guard lock(results);
    collector.add(start, std::move(outcome));
  };
  int next = 1;  // guarded by `results`
  const auto make_further = [&] {
    while (true) {
      const int start = [&] {
        const std::lock_guard lock(results);
        return next++;
      }();
      if (start >= starts) return;
      make(start);
    }
  };
  std::vector<std::jthread> others;
  for (int i = 1; i < threads; ++i) others.emplace_back(make_further);
  make(0);
  make_further();
  others.clear();  // joins them
  SolveResult answer = collector.answer(used);
  answer.times.total = gone();
  return answer;
}

}  // namespace conddp
