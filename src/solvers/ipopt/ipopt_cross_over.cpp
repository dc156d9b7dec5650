// Crossover from Ipopt's answer to the returned one.
#include <algorithm>
#include <cmath>
#include <limits>

#include "solvers/common/tuning.hpp"
#include "solvers/constraints/answer_gains.hpp"
#include "solvers/ipopt/ipopt_solver.hpp"

namespace conddp {
namespace {

using End = InteriorPointEnd;

/// Projects the multipliers of a second-order cone onto its polar cone and within their limit.
void project_on_cone(const NodeConstraint& c, Eigen::Ref<Eigen::VectorXd> nu) {
  const Eigen::VectorXd given = nu;
  outside_cone(given.data(), c.term->rows, nu.data());
  const double norm = nu.norm();
  if (norm > c.limit) nu *= c.limit / norm;
}

/// Projects the multipliers of bounded rows onto the signs of their bounds and within their limit.
void project_on_bounds(const NodeConstraint& c, Eigen::Ref<Eigen::VectorXd> nu) {
  for (int i = 0; i < c.term->rows; ++i)
    nu[i] = std::clamp(nu[i], std::isinf(c.lower[i]) ? 0 : -c.limit,
                       std::isinf(c.upper[i]) ? 0 : c.limit);
}

/// Projects multipliers onto the normal cones of their sets and within the limits of soft
/// constraints. Ipopt's multipliers satisfy these only at an answer.
void project_multipliers(const ShootingProblem& problem, Eigen::VectorXd& multipliers) {
  for (const NodeConstraint& c : problem.constraints()) {
    if (c.term->has_pairs()) continue;
    const auto project = c.term->is_cone() ? project_on_cone : project_on_bounds;
    project(c, multipliers.segment(c.row, c.term->rows));
  }
}

double bound_ratio(double multiplier, double distance) {
  return std::abs(multiplier) / std::max(distance, std::numeric_limits<double>::epsilon());
}

}  // namespace

/// Multiplier over distance, for all control bounds and all inequality rows.
IpoptSolver::BoundRatios IpoptSolver::bound_ratios(const InteriorPointAnswer& answer,
                                                   const Trajectory& trajectory,
                                                   const Eigen::VectorXd& multipliers) const {
  BoundRatios ratios{problem_.create_trajectory(), problem_.create_trajectory(),
                     row_ratios(multipliers)};
  transcription_->read_controls(answer.point.lower.data(), ratios.lower);
  transcription_->read_controls(answer.point.upper.data(), ratios.upper);
  for (int k = 0; k < problem_.knots(); ++k)
    for (int i = 0; i < problem_.nu(k); ++i) {
      const double u = trajectory.u(k)[i];
      ratios.lower.u(k)[i] = bound_ratio(ratios.lower.u(k)[i], u - bounds_.lower(k)[i]);
      ratios.upper.u(k)[i] = bound_ratio(ratios.upper.u(k)[i], bounds_.upper(k)[i] - u);
    }
  return ratios;
}

Eigen::VectorXd IpoptSolver::row_ratios(const Eigen::VectorXd& multipliers) const {
  Eigen::VectorXd ratios = Eigen::VectorXd::Zero(multipliers.size());
  for (const NodeConstraint& c : problem_.constraints())
    for (int i = 0; c.lower != nullptr && i < c.term->rows; ++i) {
      const double nu = multipliers[c.row + i], g = newton_.linearization().constraint[c.row + i];
      if (c.lower[i] < c.upper[i])
        ratios[c.row + i] = bound_ratio(nu, nu > 0 ? c.upper[i] - g : g - c.lower[i]);
    }
  return ratios;
}

/// An interior point stays away from bounds. A control belongs at a bound if, without the bound,
/// its multiplier would move the control beyond it. The curvature of the control determines this
/// move or, for the later of two answers, the mean of both ratios.
void IpoptSolver::snap_controls(const InteriorPointAnswer& answer, Trajectory& trajectory) const {
  Trajectory lower = problem_.create_trajectory(), upper = lower;
  transcription_->read_controls(answer.point.lower.data(), lower);
  transcription_->read_controls(answer.point.upper.data(), upper);
  for (int k = 0; k < problem_.knots(); ++k) {
    auto u = trajectory.u(k);
    for (int i = 0; i < u.size(); ++i) {
      const int column = problem_.ndx() + i;
      const double curvature = std::max(tuning::kSmallestCurvature,
                                        newton_.linearization().knots[k].hessian()(column, column));
      const double low = bounds_.lower(k)[i], up = bounds_.upper(k)[i];
      if ((u[i] - low) * (scales_ ? scales_->lower.u(k)[i] : curvature) < lower.u(k)[i]) u[i] = low;
      if ((up - u[i]) * (scales_ ? scales_->upper.u(k)[i] : curvature) < upper.u(k)[i]) u[i] = up;
    }
  }
}

/// Crosses over from Ipopt's answer, or the best iterate, to an answer that may be returned. This
/// is the best of three: that point, the point with entries put on their bounds, and the Newton
/// iterates from there. `goes_on`: Ipopt continued to this answer from the previous one.
void IpoptSolver::cross_over(const InteriorPointAnswer& answer, bool goes_on) {
  transcription_->set_point(answer.is_good() ? answer.point.y.data() : best_.data());
  const Eigen::VectorXd multipliers = multipliers_of(answer);
  Trajectory trajectory = transcription_->trajectory();
  bounds_.clamp(trajectory);
  start_newton(trajectory, multipliers);
  consider();
  if (!answer.is_good()) return;
  compare_ratios(bound_ratios(answer, trajectory, multipliers), goes_on);
  if (newton_.active_rows() == 0 && under_tolerances(newton_.norms())) return;
  snap_controls(answer, trajectory);
  start_newton(trajectory, multipliers);
  consider(true);
  take_newton_steps();
}

/// Constraint multipliers for the start of Newton's method.
Eigen::VectorXd IpoptSolver::multipliers_of(const InteriorPointAnswer& answer) const {
  Eigen::MatrixXd costates;
  Eigen::VectorXd multipliers;
  transcription_->read_multipliers(answer.point.rows.data(), costates, multipliers);
  if (!multipliers.allFinite()) multipliers.setZero();
  if (answer.end != End::solved) project_multipliers(problem_, multipliers);
  return multipliers;
}

void IpoptSolver::take_newton_steps() {
  for (int i = 0; i < tuning::kTries && newton_.norms().largest() > tuning::kRounding; ++i) {
    if (!newton_.step(tuning::kNewtonGrowth)) break;
    note_newton_step();
  }
}

/// From one answer to the next, the barrier falls. At an active bound the distance falls with it,
/// and the ratio grows; at an inactive bound the multiplier falls, and the ratio with it. The
/// geometric mean of both ratios is therefore a scale that tells the bounds apart by the later
/// multiplier and distance, whatever their units.
void IpoptSolver::compare_ratios(BoundRatios ratios, bool goes_on) {
  scales_.reset();
  if (goes_on) {
    scales_ = ratios;
    for (int k = 0; k < problem_.knots(); ++k) {
      scales_->lower.u(k).array() = (ratios.lower.u(k).array() * former_.lower.u(k).array()).sqrt();
      scales_->upper.u(k).array() = (ratios.upper.u(k).array() * former_.upper.u(k).array()).sqrt();
    }
    scales_->rows.array() = (ratios.rows.array() * former_.rows.array()).sqrt();
  }
  former_ = std::move(ratios);
}

/// Starts Newton's method at a trajectory, with gains that belong to it.
void IpoptSolver::start_newton(const Trajectory& trajectory, const Eigen::VectorXd& multipliers) {
  const AnswerGains gains = gains_at(problem_, bounds_, evaluator_, trajectory, multipliers);
  gain_regularization_ = gains.regularization;
  Eigen::VectorXd penalty = gains.penalty;
  if (scales_) penalty = (scales_->rows.array() > 0).select(scales_->rows, penalty);
  newton_.start(trajectory, multipliers, penalty, gains.feedback);
}

/// A slack of 1e-5 with an equally small multiplier is complementary to Ipopt's tolerances. Such a
/// bound is neither clearly active nor inactive, and Newton's method may not find out which. Ipopt
/// therefore continues until the two are further apart. Until then, an answer may look worse than
/// the previous one.
void IpoptSolver::refine(InteriorPointAnswer& answer) {
  InteriorPointSettings settings = default_settings();
  while (answer.end == End::solved && stop_ == Stop::none && !choice_.is_solution() &&
         row_.iteration < options_.max_iterations &&
         settings.tolerance * tuning::kRefinement >= tuning::kRounding) {
    settings.tolerance *= tuning::kRefinement;
    settings.dual_tolerance *= tuning::kRefinement;
    settings.complementarity_tolerance *= tuning::kRefinement;
    settings.warm = &answer.point;
    settings.warm_barrier = answer.barrier;
    iterations_before_ = row_.iteration;
    InteriorPointAnswer tighter = run_ipopt(answer.point.y, settings);
    if (tighter.end != End::solved) break;
    answer = std::move(tighter);
    cross_over(answer, true);
  }
}

/// Gains of Newton steps belong to the previous iterate and treat active controls as stiff
/// penalties. If only controls are bounded, a sweep at the answer gives its own gains. Controls
/// that miss their bounds by rounding would be free in that sweep.
void IpoptSolver::sweep_at_answer() {
  if (!choice_.is_solution() || !problem_.constraints().empty()) return;
  Trajectory trajectory = result_.trajectory;
  bounds_.snap_rounded(trajectory);
  start_newton(trajectory, Eigen::VectorXd(result_.constraint_multipliers));
  if (gain_regularization_) consider(true);
}

}  // namespace conddp
