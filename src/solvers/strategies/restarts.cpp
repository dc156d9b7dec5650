#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <map>
#include <mutex>
#include <optional>
#include <thread>

#include <fmt/format.h>

#include "solvers/common/guess.hpp"
#include "solvers/common/tuning.hpp"
#include "solvers/strategies/joined_solves.hpp"
#include "solvers/strategies/strategies.hpp"

namespace conddp {
namespace {

bool equal_costs(double a, double b) {
  return std::abs(a - b) <= tuning::kEqualCost * std::max(std::abs(a), std::abs(b));
}

/// True if two answers are least violations of equal size.
bool equal_violations(const SolveResult& a, const SolveResult& b) {
  return a.status == SolveStatus::infeasible && b.status == SolveStatus::infeasible &&
         std::abs(a.residuals.constraint - b.residuals.constraint) <=
             tuning::kEqualCost * a.residuals.constraint;
}

/// Largest entry of x_k ⊖ y_k over all nodes. `y` may be the state of one node throughout.
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
  return distance(problem, a, [&](int k) { return b.x(k); }) <= tuning::kEqualStates * extent;
}

struct Outcome {
  std::optional<SolveResult> result;  ///< empty for a start that was not made
  const SolverInfo* used = nullptr;
  std::exception_ptr failure;
};

/// Takes outcomes in the order of their starts, whatever the order of their arrival.
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
    if (is_success(result.status)) {
      ++record_.converged;
      count(result);
    }
    if (best_.result && !is_better(result, *best_.result)) return;
    record_.answer = next_;
    best_ = std::move(outcome);
  }

  static bool is_better(const SolveResult& result, const SolveResult& best) {
    if (!is_success(result.status)) return false;
    if (!is_success(best.status)) return true;
    return result.cost < best.cost && !equal_costs(result.cost, best.cost);
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

/// Starts of a problem, made in several threads.
class Restarts {
 public:
  Restarts(const ShootingProblem& problem, const SolverOptions& options, const Trajectory& guess,
           const Solve& solve)
      : problem_(problem), options_(options), guess_(guess), solve_(solve), collector_(problem) {}

  SolveResult run(int threads, const SolverInfo*& used) {
    threads = std::min(threads, starts());
    own_ = options_;
    own_.restarts = {};
    own_.on_iteration = nullptr;
    own_.interrupted = [this] { return interrupted(); };
    if (threads > 1) own_.threads = 1;
    {
      std::vector<std::jthread> others;
      for (int i = 1; i < threads; ++i) others.emplace_back([this] { make_further(); });
      make(0);
      make_further();
    }
    SolveResult answer = collector_.answer(used);
    answer.times.total = gone();
    return answer;
  }

 private:
  int starts() const { return options_.restarts.count + 1; }
  double gone() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
  }
  bool interrupted() {
    const std::lock_guard lock(callbacks_);
    return interrupted_ = interrupted_ || (options_.interrupted && options_.interrupted());
  }

  /// Makes the starts that have not begun.
  void make_further() {
    for (int start = take_next(); start < starts(); start = take_next()) make(start);
  }
  int take_next() {
    const std::lock_guard lock(results_);
    return next_++;
  }

  void make(int start) {
    Outcome outcome;
    try {
      outcome = solve(start);
    } catch (...) {
      outcome.failure = std::current_exception();
    }
    const std::lock_guard lock(results_);
    collector_.add(start, std::move(outcome));
  }

  /// The first start is always made, others while time remains.
  Outcome solve(int start) {
    SolverOptions mine = own_;
    if (start == 0) {
      if (options_.on_iteration)
        mine.on_iteration = [this](const IterationRecord& row) {
          const std::lock_guard lock(callbacks_);
          options_.on_iteration(row);
        };
    } else {
      mine.max_time_s = options_.max_time_s - gone();
      if (!(mine.max_time_s > 0) || interrupted()) return {};
    }
    Outcome outcome;
    outcome.result =
        solve_(start_of(problem_, options_.restarts, guess_, start), mine, outcome.used);
    return outcome;
  }

  const ShootingProblem& problem_;
  const SolverOptions& options_;
  const Trajectory& guess_;
  const Solve& solve_;
  SolverOptions own_;  ///< options of every start
  const std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  std::mutex callbacks_, results_;
  bool interrupted_ = false;  ///< guarded by `callbacks_`
  int next_ = 1;              ///< guarded by `results_`
  Collector collector_;       ///< guarded by `results_`
};

}  // namespace

Trajectory start_of(const ShootingProblem& problem, const SolverOptions::Restarts& restarts,
                    const Trajectory& guess, int start) {
  if (start == 0) return guess;
  const auto seed = static_cast<std::uint64_t>(restarts.seed) * 1000003 + start;
  return perturb_guess(problem, guess, restarts.spread, seed);
}

Attempt attempt_of(const SolverInfo& solver, int start, const SolveResult& result,
                   const Objection& objection) {
  return {.solver = solver.name,
          .start = start,
          .status = result.status,
          .iterations = result.iterations,
          .cost = result.cost,
          .time_s = result.times.total,
          .objection = objection.text,
          .jumps = objection.jumps};
}

SolveResult solve_restarts(const ShootingProblem& problem, const SolverOptions& options,
                           const Trajectory& guess, int threads, const Solve& solve,
                           const SolverInfo*& used) {
  return Restarts(problem, options, guess, solve).run(threads, used);
}

SolveResult solve_from_elsewhere(const ShootingProblem& problem, const SolverOptions& options,
                                 const Trajectory& guess, SolveResult failed, double spread,
                                 const Solve& solve, const Doubt& doubt, const SolverInfo*& used) {
  const SolverOptions::Restarts far{.seed = options.restarts.seed, .spread = spread};
  JoinedSolves solves(options);
  RestartRecord record{.starts = 1};
  std::optional<SolveResult> found;
  std::vector<Attempt> attempts = failed.attempts;
  int alike = 1;
  for (int start = 1; start <= tuning::kTries && solves.iterations_left() > 0; ++start) {
    if (!(options.max_time_s > solves.seconds()) || (options.interrupted && options.interrupted()))
      break;
    const SolverInfo* by = nullptr;
    SolveResult result = solve(start_of(problem, far, guess, start), solves.next(), by);
    solves.add(result);
    attempts.push_back(attempt_of(*by, start, result, {}));
    if (alike == record.starts++ && equal_violations(failed, result) &&
        ++alike == tuning::kAlikeStarts) {
      failed.message += fmt::format("; the violation is the same from {} starts", alike);
      break;
    }
    if (!is_success(result.status)) continue;
    if (doubt) attempts.back() = attempt_of(*by, start, result, doubt(problem, result));
    const std::string& doubts = attempts.back().objection;
    if (!doubts.empty() && found) continue;
    for (Attempt& attempt : attempts) attempt.chosen = &attempt == &attempts.back();
    used = by;
    record.converged = 1;
    record.answer = start;
    record.basins = {{.cost = result.cost, .starts = 1, .first = start}};
    result.message = fmt::format("{}; {} from restart {} of at most {}: {}", failed.message,
                                 by->name, start, tuning::kTries, result.message);
    found = std::move(result);
    if (doubts.empty()) break;
  }
  const double before = failed.times.total;
  SolveResult answer = found ? *std::move(found) : std::move(failed);
  answer.times.total = before + solves.seconds();
  answer.attempts = std::move(attempts);
  if (record.starts > 1) answer.restarts = std::move(record);
  return answer;
}

}  // namespace conddp
