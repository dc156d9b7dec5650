#include "solvers/common/solve_record.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace conddp {
namespace {

/// Maximum number of log rows reserved before the first iteration.
constexpr int kReservedRows = 10000;
/// Longer than any message of this program.
constexpr int kReservedMessage = 1000;

}  // namespace

SolveRecord::SolveRecord(const ShootingProblem& problem, const SolverOptions& options,
                         bool constrained)
    : result(problem),
      problem_(problem),
      options_(options),
      constrained_(constrained),
      blank_(problem) {
  blank_.feedback.k.clear();
  blank_.feedback.K.clear();
}

void SolveRecord::begin() {
  began_ = std::chrono::steady_clock::now();
  row = IterationRecord();
  if (!result.control_gradient.empty()) gradient_ = std::move(result.control_gradient);
  Feedback feedback = std::move(result.feedback);
  result = blank_;
  result.feedback = std::move(feedback);
  result.log.reserve(std::min(options_.max_iterations, kReservedRows) + 1);
  result.message.reserve(kReservedMessage);
  result.start.reserve(kReservedMessage);
  log_is_stale = false;
}

void SolveRecord::log_row() {
  row.time_s = elapsed();
  result.log.push_back(row);
  log_is_stale = false;
  if (options_.on_iteration) options_.on_iteration(row);
}

bool SolveRecord::end(SolveStatus status, std::string_view message) {
  result.status = status;
  result.message = message;
  return false;
}

bool SolveRecord::budget_left() {
  if (options_.interrupted && options_.interrupted())
    return end(SolveStatus::interrupted, "interrupted: {}", residual_text());
  if (elapsed() >= options_.max_time_s)
    return end(SolveStatus::time_limit, "the time is up: {}", residual_text());
  return true;
}

bool SolveRecord::may_continue() {
  if (row.iteration >= options_.max_iterations)
    return end(SolveStatus::max_iterations, "not converged after {} iterations: {}", row.iteration,
               residual_text());
  return budget_left();
}

void SolveRecord::write_residuals() {
  result.residuals = {.stationarity = row.stationarity,
                      .gap = row.gap,
                      .constraint = row.constraint,
                      .complementarity = row.complementarity,
                      .stationarity_knot = row.stationarity_knot,
                      .gap_knot = row.gap_knot,
                      .constraint_knot = row.constraint_knot};
}

std::string_view SolveRecord::residual_text() {
  text_.clear();
  const auto out = std::back_inserter(text_);
  const auto add = [&](const char* name, double value, int knot) {
    fmt::format_to(out, "{} {:.1e}", name, value);
    if (knot >= 0) fmt::format_to(out, " (knot {})", knot);
  };
  add("stationarity", row.stationarity, row.stationarity_knot);
  add(", gap", row.gap, row.gap_knot);
  add(", constraint violation", row.constraint, constrained_ ? row.constraint_knot : -1);
  if (constrained_) add(", complementarity", row.complementarity, -1);
  return {text_.data(), text_.size()};
}

double SolveRecord::elapsed() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
}

std::vector<Eigen::VectorXd>& SolveRecord::control_gradient() {
  result.control_gradient = std::move(gradient_);
  result.control_gradient.resize(problem_.knots());
  for (int k = 0; k < problem_.knots(); ++k) result.control_gradient[k].resize(problem_.nu(k));
  return result.control_gradient;
}

SolveResult& SolveRecord::finished() {
  if (!result.feedback_regularization) result.feedback.set_zero();
  result.iterations = row.iteration;
  result.times.total = elapsed();
  return result;
}

}  // namespace conddp
