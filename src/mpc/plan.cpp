#include "mpc/plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ocp/problem/by_name.hpp"

namespace conddp {
namespace {

/// u += K tangent.
void add_feedback(const Eigen::MatrixXd& K, const std::vector<double>& tangent,
                  Eigen::VectorXd& u) {
  for (Eigen::Index j = 0; j < K.cols(); ++j) u += tangent[j] * K.col(j);
}

/// Zeroes the difference of the previous control.
void forget(const Step& step, std::vector<double>& tangent) {
  for (int i = 0; i < step.tail(); ++i)
    if (step.source(i)) tangent[step.system().ndx() + i] = 0;
}

}  // namespace

void clip_control(const KnotModel& model, Eigen::VectorXd& u) {
  for (int i = 0; i < model.nu(); ++i)
    u[i] = std::max(model.control_lower()[i], std::min(model.control_upper()[i], u[i]));
}

Plan::Plan(const ShootingProblem& p)
    : problem(&p),
      times(p.knots() + 1),
      trajectory(p.create_trajectory()),
      feedback(p),
      multipliers(Eigen::VectorXd::Zero(p.constraint_rows())) {}

int Plan::knot_at(double time) const {
  const auto after = std::upper_bound(times.begin(), times.end() - 1, time + kSameTime);
  int k = std::max(0, static_cast<int>(after - times.begin()) - 1);
  while (k > 0 && problem->takes_no_time(k)) --k;
  return k;
}

void Plan::state_at(double time, bool before, double* tangent, double* x) const {
  const int last = problem->knots();
  const auto copy = [&](int k) { std::copy_n(trajectory.x(k).data(), problem->nx(), x); };
  if (before) {
    const auto first = std::lower_bound(times.begin(), times.end(), time - kSameTime);
    const int k = static_cast<int>(first - times.begin());
    if (k > last) return copy(last);
    if (!is_before(time, times[k])) return copy(k);
  }
  const auto after = std::upper_bound(times.begin(), times.end(), time + kSameTime);
  const int k = static_cast<int>(after - times.begin()) - 1;
  if (k < 0) return copy(0);
  if (k >= last || !is_before(times[k], time)) return copy(std::min(k, last));
  const double share = (time - times[k]) / (times[k + 1] - times[k]);
  const StateManifold& manifold = problem->manifold();
  manifold.difference(trajectory.x(k).data(), trajectory.x(k + 1).data(), tangent);
  for (int i = 0; i < problem->ndx(); ++i) tangent[i] *= share;
  manifold.integrate(trajectory.x(k).data(), tangent, x);
  // Inside a knot, the previous control is the knot's own.
  problem->knot(k).model->step().hand_on(trajectory.u(k).data(), x);
}

void planned_control(const Plan& plan, double time, Eigen::VectorXd& u) {
  const int k = plan.knot_at(time);
  u = plan.trajectory.u(k);
  clip_control(*plan.problem->knot(k).model, u);
}

void control_of(const Plan& plan, double time, const double* planned, const double* x,
                PolicyScratch& scratch, Eigen::VectorXd& u) {
  const int k = plan.knot_at(time);
  u = plan.trajectory.u(k);
  plan.problem->manifold().difference(planned, x, scratch.tangent.data());
  // Gains respond to the control before the knot, which is unknown inside the knot.
  if (is_before(plan.times[k], time)) forget(plan.problem->knot(k).model->step(), scratch.tangent);
  add_feedback(plan.feedback.K[k], scratch.tangent, u);
  clip_control(*plan.problem->knot(k).model, u);
}

void control_of(const HeldState& held, const KnotModel& model, const double* x,
                PolicyScratch& scratch, Eigen::VectorXd& u) {
  u = held.u;
  model.manifold().difference(held.x.data(), x, scratch.tangent.data());
  forget(model.step(), scratch.tangent);
  add_feedback(held.K, scratch.tangent, u);
  clip_control(model, u);
}

bool is_better(const TrialFigures& a, const TrialFigures& b, double tolerance) {
  const bool same = a.violation == b.violation || std::abs(a.violation - b.violation) <= tolerance;
  return same ? a.cost < b.cost : a.violation < b.violation;
}

PlanTrial::PlanTrial(const ShootingProblem& window)
    : evaluator_(window), rollout_(window), evaluation_(window) {}

TrialFigures PlanTrial::follow(const Trajectory& plan, const Feedback& feedback) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  // Step length 0 keeps the controls of the plan; the gains still act.
  evaluator_.roll_out(plan, evaluation_.gap, feedback, 0, {.clamp_controls = true}, rollout_);
  if (rollout_.first_bad_knot >= 0) return {kInfinite, kInfinite};
  evaluator_.evaluate(rollout_.trajectory, evaluation_);
  TrialFigures figures{.cost = rollout_.cost};
  for (const ConstraintViolation& found :
       violations_by_name(evaluator_.problem(), evaluation_.constraint))
    figures.violation = std::max(figures.violation, found.value);
  return figures;
}

}  // namespace conddp
