#include "solvers/constraints/projected_newton.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ocp/problem/problem.hpp"
#include "solvers/common/tuning.hpp"
#include "solvers/iterate/hessian_switch.hpp"

namespace conddp {
namespace {

double largest_norm(const IterationRecord& row) {
  return std::max({row.stationarity, row.gap, row.constraint});
}

}  // namespace

double KktNorms::largest() const {
  const double sum = stationarity.value + gap.value + violation.value;
  return std::isfinite(sum) ? std::max({stationarity.value, gap.value, violation.value}) : sum;
}

ProjectedNewton::ProjectedNewton(const ShootingProblem& problem, Evaluator& evaluator)
    : problem_(problem),
      evaluator_(evaluator),
      bounds_(problem),
      linearization_(problem),
      adjoint_(problem, bounds_),
      gaps_(problem),
      qp_(problem, bounds_, box_stage(problem), true, true),
      trajectory_(problem.create_trajectory()),
      before_(trajectory_),
      lagrangian_(problem),
      multipliers_(Eigen::VectorXd::Zero(problem.constraint_rows())),
      given_(multipliers_),
      given_before_(multipliers_),
      multipliers_before_(multipliers_),
      target_(multipliers_),
      penalty_(multipliers_),
      dear_(exact_hessians_are_dear(problem)) {
  evaluator.reserve_lagrangian_hessian();
  for (int k = 0; k <= problem.knots(); ++k) {
    gauss_newton_.push_back(linearization_.knots[k].hessian());
    cost_gradient_.push_back(linearization_.knots[k].gradient);
  }
  exact_ = gauss_newton_;
}

void ProjectedNewton::start(const Trajectory& trajectory, const Eigen::VectorXd& multipliers,
                            const Eigen::VectorXd& penalty, const Feedback& feedback) {
  trajectory_ = trajectory;
  multipliers_ = multipliers;
  penalty_ = penalty;
  qp_.reset();
  qp_.feedback() = feedback;
  step_length_ = 0;
  curved_ = true;
  keeps_ = false;
  exact_hessians_ = 0;
  linearize();
}

/// Computes derivatives, active rows, co-states and norms of the iterate.
void ProjectedNewton::linearize() {
  given_ = multipliers_;
  lagrangian_.multiplier.setZero();
  evaluator_.differentiate(trajectory_, linearization_, &lagrangian_);
  for (int k = 0; k <= problem_.knots(); ++k) cost_gradient_[k] = linearization_.knots[k].gradient;
  qp_.rows().choose(linearization_, penalty_, multipliers_);
  for (int k = 0; k <= problem_.knots(); ++k) {
    KnotLinearization& knot = linearization_.knots[k];
    knot.gradient.noalias() +=
        knot.C.transpose() * multipliers_.segment(problem_.constraint_offset(k), knot.C.rows());
  }
  gaps_.set(linearization_, true);
  adjoint_.compute(linearization_, trajectory_, gaps_, qp_.feedback());
  active_rows_ = qp_.rows().active_rows() + held_controls();
  measure();
}

/// Number of controls at a bound that descent would cross.
int ProjectedNewton::held_controls() const {
  int count = 0;
  for (int k = 0; k < problem_.knots(); ++k)
    for (int i = 0; i < problem_.nu(k); ++i)
      count +=
          bounds_.pushed_out(k, i, trajectory_.u(k)[i], adjoint_.gradient()[bounds_.offset(k) + i]);
  return count;
}

void ProjectedNewton::measure() {
  norms_.stationarity = bounds_.projected_norm(adjoint_.gradient(), trajectory_);
  norms_.violation = largest_violation(problem_, bounds_, trajectory_, linearization_.constraint);
  norms_.complementarity = 0;
  for (const NodeConstraint& c : problem_.constraints()) {
    norms_.complementarity = std::max(
        norms_.complementarity,
        complementarity(c, linearization_.constraint.data() + c.row, multipliers_.data() + c.row));
  }
  norms_.gap = {};
  for (int k = 0; k < problem_.knots(); ++k) {
    const double gap = linearization_.gap.col(k).lpNorm<Eigen::Infinity>();
    norms_.gap.meet(gap, k);
  }
}

/// Finds the step and target_. If the exact Hessian is not convex on the active rows, the
/// Gauss-Newton one is used.
bool ProjectedNewton::solve_quadratic() {
  const double penalty = tuning::kRowPenalty * std::max(take_hessians(), tuning::kLeastCurvature);
  return (curved_ && solve_with(exact_, penalty)) || solve_with(gauss_newton_, penalty);
}

/// Stores the Gauss-Newton Hessians and, if they differ, the exact ones. Returns the largest
/// curvature of the former or, for linear costs, of the latter.
double ProjectedNewton::take_hessians() {
  double curvature = 0;
  for (std::size_t k = 0; k < gauss_newton_.size(); ++k) {
    gauss_newton_[k] = linearization_.knots[k].hessian();
    curvature = std::max(curvature, gauss_newton_[k].diagonal().maxCoeff());
  }
  if (curved_ && !keeps_) evaluate_exact_hessian();
  if (curvature < tuning::kLeastCurvature && curved_)
    for (const Eigen::MatrixXd& hessian : exact_)
      curvature = std::max(curvature, hessian.diagonal().cwiseAbs().maxCoeff());
  return curvature;
}

void ProjectedNewton::evaluate_exact_hessian() {
  ++exact_hessians_;
  lagrangian_.multiplier = multipliers_;
  evaluator_.lagrangian_hessian(trajectory_, adjoint_.costates(), linearization_, &lagrangian_);
  curved_ = false;
  for (std::size_t k = 0; k < exact_.size(); ++k) {
    exact_[k] = linearization_.knots[k].hessian();
    curved_ = curved_ || !same_hessian(exact_[k], gauss_newton_[k]);
  }
}

/// Solves the horizon QP with these Hessians. False if it lacks a minimum.
bool ProjectedNewton::solve_with(const std::vector<Eigen::MatrixXd>& hessians, double penalty) {
  for (std::size_t k = 0; k < hessians.size(); ++k) {
    linearization_.knots[k].gradient = cost_gradient_[k];
    linearization_.knots[k].hessian.change() = hessians[k];
  }
  target_ = multipliers_;
  qp_.rows().choose(linearization_, penalty_, target_);
  return qp_.satisfy({linearization_, trajectory_, gaps_, adjoint_.gradient()}, penalty, target_);
}

bool ProjectedNewton::step(double growth) {
  const double was = norms_.largest();
  const int sweeps_before = qp_.sweeps();
  bool stepped = try_step(growth * was);
  if (!stepped && keeps_) {
    keeps_ = false;
    stepped = try_step(growth * was);
  }
  sweeps_ = qp_.sweeps() - sweeps_before;
  keeps_ = stepped && dear_ && step_length_ == 1 && norms_.largest() <= tuning::kTighter * was;
  return stepped;
}

/// Takes a step after which the largest norm is below the bound.
bool ProjectedNewton::try_step(double bound) {
  before_ = trajectory_;
  given_before_ = given_;
  const auto return_to_start = [this] {
    trajectory_ = before_;
    multipliers_ = given_before_;
    step_length_ = 0;
    linearize();
    return false;
  };
  if (!solve_quadratic()) return return_to_start();
  multipliers_before_ = multipliers_;
  for (step_length_ = 1; step_length_ >= tuning::kShortestHalf; step_length_ /= 2) {
    move();
    linearize();
    if (norms_.largest() < (1 - tuning::kNewtonDecrease * step_length_) * bound) return true;
  }
  return return_to_start();
}

/// Moves by step_length_ of the step, from its start.
void ProjectedNewton::move() {
  trajectory_ = before_;
  qp_.step().apply(problem_.manifold(), step_length_, trajectory_);
  bounds_.clamp(trajectory_);
  multipliers_ = multipliers_before_ + step_length_ * (target_ - multipliers_before_);
}

double ProjectedNewton::cost() const {
  return linearization_.total_cost() + linear_soft_cost(problem_, linearization_.constraint);
}

void ProjectedNewton::write_answer(SolveResult& result) const {
  result.trajectory = trajectory_;
  result.cost = cost();
  result.residuals = {.stationarity = norms_.stationarity.value,
                      .gap = norms_.gap.value,
                      .constraint = norms_.violation.value,
                      .complementarity = norms_.complementarity,
                      .stationarity_knot = norms_.stationarity.knot,
                      .gap_knot = norms_.gap.knot,
                      .constraint_knot = norms_.violation.knot};
  result.feedback = feedback();
  result.costates = adjoint_.costates();
  result.state_gradient = adjoint_.state_gradient();
  result.control_gradient.clear();
  for (int k = 0; k < problem_.knots(); ++k)
    result.control_gradient.push_back(
        adjoint_.gradient().segment(bounds_.offset(k), problem_.nu(k)));
  result.constraint_values = linearization_.constraint;
  result.constraint_multipliers = multipliers_;
}

void ProjectedNewton::describe(IterationRecord& row) const {
  row.cost = row.merit = cost();
  row.stationarity = norms_.stationarity.value;
  row.stationarity_knot = norms_.stationarity.knot;
  row.gap = norms_.gap.value;
  row.gap_knot = norms_.gap.knot;
  row.constraint = norms_.violation.value;
  row.constraint_knot = norms_.violation.knot;
  row.complementarity = norms_.complementarity;
  row.step = step_length_;
  row.active_rows = active_rows();
  row.sweeps = sweeps_;
  row.regularization = row.barrier = row.expected_decrease = row.actual_decrease = 0;
  row.trials = row.clamped_controls = row.active_set_changes = 0;
}

NewtonPolish::NewtonPolish(const ShootingProblem& problem, Evaluator& evaluator,
                           const SolverOptions& options)
    : newton_(problem, evaluator), options_(options) {}

void NewtonPolish::reset() { threshold_ = tuning::kNewtonFrom; }

/// Takes steps until nothing is left to gain, or too many of them are damped.
void NewtonPolish::iterate_newton(SolveRecord& record) {
  IterationRecord& row = record.row;
  int damped = 0;
  for (int i = 0; i < tuning::kTries && row.iteration < options_.max_iterations; ++i) {
    if (newton_.norms().largest() <= tuning::kRounding || !newton_.step()) return;
    ++row.iteration;
    ++row.newton;
    newton_.describe(row);
    record.log_row();
    record.log_is_stale = true;  // until the iterate is accepted
    damped += newton_.step_length() < 1;
    if (damped > tuning::kDampedSteps) return;
  }
}

bool NewtonPolish::due(const IterationRecord& row) const {
  return !(largest_norm(row) > threshold_);
}

bool NewtonPolish::run(Iterate& iterate, const Feedback& feedback, OuterStrategy& outer,
                       SolveRecord& record) {
  IterationRecord& row = record.row;
  const IterationRecord start = row;
  newton_.start(iterate.trajectory, *outer.multipliers(), outer.augmentation()->penalty, feedback);
  iterate_newton(record);
  threshold_ = tuning::kTighter * largest_norm(start);
  const auto& tolerance = options_.tolerances;
  const KktNorms& norms = newton_.norms();
  // Without a step, Newton's multipliers are no better than the present ones.
  const bool stands =
      row.iteration == start.iteration && norms.complementarity > tolerance.complementarity;
  if (stands || norms.stationarity.value > tolerance.stationarity ||
      norms.gap.value > tolerance.gap || norms.violation.value > tolerance.constraint) {
    const int iteration = row.iteration, newton = row.newton;
    row = start;
    row.iteration = iteration;
    row.newton = newton;
    return false;
  }
  iterate.before = iterate.trajectory;
  iterate.trajectory = newton_.trajectory();
  iterate.linearized = iterate.differentiated = false;
  outer.adopt(newton_.multipliers());
  record.log_is_stale = false;
  return true;
}

}  // namespace conddp
