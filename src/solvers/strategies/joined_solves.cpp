#include "solvers/strategies/joined_solves.hpp"

#include <algorithm>
#include <cmath>

namespace conddp {

int JoinedSolves::iterations_left() const {
  return std::max(0, options_.max_iterations - iterations_);
}

double JoinedSolves::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
}

SolverOptions JoinedSolves::next(Mark mark) {
  mark_ = std::move(mark);
  solve_began_ = seconds();
  SolverOptions own = options_;
  own.max_iterations = iterations_left();
  if (solves_ > 0) own.max_time_s = std::max(1e-3, options_.max_time_s - solve_began_);
  if (options_.interrupted)
    own.interrupted = [this] { return interrupted_ = interrupted_ || options_.interrupted(); };
  if (options_.on_iteration)
    own.on_iteration = [this](const IterationRecord& row) { options_.on_iteration(placed(row)); };
  return own;
}

void JoinedSolves::add(const SolveResult& result) {
  for (const IterationRecord& row : result.log) log_.push_back(placed(row));
  if (solves_++ == 0) start_ = result.start;
  iterations_ += result.iterations;
  for (double SolveTimes::*time : {&SolveTimes::evaluate, &SolveTimes::differentiate,
                                   &SolveTimes::sweep, &SolveTimes::rollout})
    times_.*time += result.times.*time;
}

SolveResult JoinedSolves::answer(SolveResult last) {
  last.iterations = iterations_;
  last.times = times_;
  last.times.total = seconds();
  last.log = std::move(log_);
  last.start = std::move(start_);
  return last;
}

IterationRecord JoinedSolves::placed(IterationRecord row) const {
  row.iteration += iterations_;
  row.time_s += solve_began_;
  if (mark_) mark_(row);
  return row;
}

double next_first_penalty(const SolverOptions& options, const SolveResult& last) {
  const auto& augmented = options.augmented_lagrangian;
  const double needed = last.log.empty() ? 0 : last.log.back().constraint_penalty;
  if (!(needed > augmented.initial_penalty)) return augmented.initial_penalty;
  return std::min(std::sqrt(augmented.initial_penalty * needed), augmented.max_penalty);
}

}  // namespace conddp
