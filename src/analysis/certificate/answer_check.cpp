#include "analysis/certificate/answer_check.hpp"

#include <algorithm>

#include "analysis/certificate/reduced_gradient.hpp"
#include "analysis/derivatives/node_models.hpp"
#include "ocp/evaluation/evaluator.hpp"
#include "ocp/problem/by_name.hpp"
#include "ocp/problem/problem.hpp"

namespace conddp {
namespace {

double bound_violation(const ShootingProblem& problem, const Trajectory& trajectory) {
  double worst = 0;
  for (int k = 0; k < problem.knots(); ++k) {
    const KnotModel& model = *problem.knot(k).model;
    for (int i = 0; i < problem.nu(k); ++i) {
      const double u = trajectory.u(k)[i];
      worst = std::max({worst, model.control_lower()[i] - u, u - model.control_upper()[i]});
    }
  }
  return worst;
}

bool is_finite(const Linearization& linearization) {
  const auto finite = [](const KnotLinearization& knot) {
    return knot.gradient.allFinite() && knot.hessian().allFinite() && knot.F.allFinite();
  };
  return linearization.cost.allFinite() && linearization.gap.allFinite() &&
         std::all_of(linearization.knots.begin(), linearization.knots.end(), finite);
}

}  // namespace

AnswerCheck check_answer(const ShootingProblem& problem, const Trajectory& trajectory,
                         double bound_tolerance, const Eigen::VectorXd& constraint_multipliers) {
  AnswerCheck check;
  Evaluator evaluator(problem);
  Linearization linearization(problem);
  Augmentation lagrangian(problem);
  const bool multipliers_known = constraint_multipliers.size() == problem.constraint_rows();
  if (multipliers_known) lagrangian.multiplier = constraint_multipliers;
  evaluator.differentiate(trajectory, linearization, &lagrangian);
  if (!is_finite(linearization)) return check;
  check.cost = linearization.total_cost() + linear_soft_cost(problem, linearization.constraint);
  Eigen::VectorXd start(problem.ndx());
  problem.manifold().difference(problem.initial_state().data(), trajectory.x(0).data(),
                                start.data());
  check.gap = std::max(linearization.max_gap(), start.lpNorm<Eigen::Infinity>());
  check.constraint = bound_violation(problem, trajectory);
  for (const ConstraintViolation& violation : violations_by_name(problem, linearization.constraint))
    check.constraint = std::max(check.constraint, violation.value);
  if (!multipliers_known) return check;
  // The linearization above includes the multiplier terms of constraints.
  const NodeModels models =
      problem.constraint_rows() == 0
          ? confirmed_models(problem, trajectory, linearization.gap, linearization)
          : node_models(problem, trajectory, linearization.gap);
  const RiccatiPolicy policy =
      riccati_policy(problem, trajectory, models.derivatives, models.hessians, bound_tolerance);
  const ProjectedGradient gradient =
      project(problem, trajectory,
              adjoint_pass(problem, models.derivatives, constraint_multipliers, policy.K).control,
              bound_tolerance);
  check.stationarity = gradient.stationarity;
  check.complementarity = gradient.product;
  for (const NodeConstraint& c : problem.constraints())
    check.complementarity =
        std::max(check.complementarity, complementarity(c, linearization.constraint.data() + c.row,
                                                        constraint_multipliers.data() + c.row));
  return check;
}

}  // namespace conddp
