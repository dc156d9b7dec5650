#include "solvers/common/solve_record.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace conddp {
namespace {

/// Rows of the log that are reserved at most before the first iteration.
constexpr int kReservedRows = 10000;

}  // namespace

SolveRecord::SolveRecord(const ShootingProblem& problem, const SolverOptions& options,
                         bool constrained)
    : result(problem), problem_(problem), options_(options), constrained_(constrained) {}

void SolveRecord::begin() {
  began_ = std::chrono::steady_clock::now();
  row = IterationRecord();
  result = SolveResult(problem_);
  result.log.reserve(std::min(options_.max_iterations, kReservedRows) + 1);
  log_is_stale = false;
}

void SolveRecord::log_row() {
  row.time_s = elapsed();
  result.log.push_back(row);
  log_is_stale = false;
  if (options_.on_iteration) options_.on_iteration(row);
}

bool SolveRecord::end(SolveStatus status, std::string message) {
  result.status = status;
  result.message = std::move(message);
  return false;
}

bool SolveRecord::budget_left() {
  if (options_.interrupted && options_.interrupted())
    return end(SolveStatus::interrupted, "interrupted: " + residual_text());
  if (elapsed() >= options_.max_time_s)
    return end(SolveStatus::time_limit, "the time is up: " + residual_text());
  return true;
}

bool SolveRecord::may_continue() {
  if (row.iteration >= options_.max_iterations)
    return end(SolveStatus::max_iterations, fmt::format("not converged after {} iterations: {}",
                                                        row.iteration, residual_text()));
  return budget_left();
}

std::string SolveRecord::residual_text() const {
  const auto at = [](int knot) { return knot < 0 ? "" : fmt::format(" (knot {})", knot); };
  std::string text =
      fmt::format("stationarity {:.1e}{}", row.stationarity, at(row.stationarity_knot));
  text += fmt::format(", gap {:.1e}{}", row.gap, at(row.gap_knot));
  text += fmt::format(", constraint violation {:.1e}", row.constraint);
  if (constrained_) {
    text += at(row.constraint_knot);
    text += fmt::format(", complementarity {:.1e}", row.complementarity);
  }
  return text;
}

double SolveRecord::elapsed() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
}

SolveResult SolveRecord::take() {
  result.iterations = row.iteration;
  result.times.total = elapsed();
  return std::move(result);
}

}  // namespace conddp
