#include "analysis/answer_check.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Cholesky>

#include "ocp/acts.hpp"
#include "ocp/by_name.hpp"
#include "ocp/soft_constraint.hpp"

namespace conddp {
namespace {

/// How a control stands to its bounds.
struct BoundRelation {
  bool near = false;                 ///< at one, within the tolerance
  std::optional<double> distance{};  ///< from the one against which descent pushes it, if at that
};

BoundRelation relate(const KnotModel& model, int i, double u, double gradient, double tolerance) {
  const double lower = model.control_lower()[i], upper = model.control_upper()[i];
  const auto close = [&](double bound) {
    return std::isfinite(bound) &&
           std::abs(u - bound) <= tolerance * std::max(1.0, std::abs(bound));
  };
  const bool at_lower = u <= lower || close(lower), at_upper = u >= upper || close(upper);
  BoundRelation relation{.near = at_lower || at_upper};
  if (at_lower && gradient > 0) relation.distance = std::abs(u - lower);
  if (at_upper && gradient < 0) relation.distance = std::abs(u - upper);
  return relation;
}

/// K of the stage min over the free controls; rows of the others are zero. `value` is the Hessian
/// of the cost to go and becomes that of this node.
Eigen::MatrixXd riccati_step(const Eigen::MatrixXd& hessian, const Eigen::MatrixXd& jacobian,
                             const std::vector<int>& free, Eigen::MatrixXd& value) {
  const Eigen::Index ndx = value.rows(), nu = hessian.rows() - ndx;
  const Eigen::Index count = static_cast<Eigen::Index>(free.size());
  const Eigen::MatrixXd Q = hessian + jacobian.transpose() * value * jacobian;
  Eigen::MatrixXd Quu(count, count), Qux(count, ndx);
  for (Eigen::Index i = 0; i < count; ++i) {
    Qux.row(i) = Q.row(ndx + free[i]).head(ndx);
    for (Eigen::Index j = 0; j < count; ++j) Quu(i, j) = Q(ndx + free[i], ndx + free[j]);
  }
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(nu, ndx);
  if (count > 0) {
    const double size = std::max(1e-300, Quu.diagonal().cwiseAbs().maxCoeff());
    Eigen::LLT<Eigen::MatrixXd> factors(Quu);
    for (double mu = 1e-12 * size; factors.info() != Eigen::Success && mu < size; mu *= 100)
      factors.compute(Quu + mu * Eigen::MatrixXd::Identity(count, count));
    if (factors.info() == Eigen::Success) {
      const Eigen::MatrixXd gains = -factors.solve(Qux);
      for (Eigen::Index i = 0; i < count; ++i) K.row(free[i]) = gains.row(i);
    }
  }
  const auto Qzu = Q.rightCols(nu);
  value = Q.topLeftCorner(ndx, ndx) + K.transpose() * Qzu.bottomRows(nu) * K +
          Qzu.topRows(ndx) * K + (Qzu.topRows(ndx) * K).transpose();
  value = (0.5 * (value + value.transpose())).eval();
  return K;
}

/// λ ← (Ad exp(gap))ᵀ λ: a co-state at x_{k+1} as one at f(x_k, u_k), where tangent vectors differ
/// on curved spaces.
void transport(const StateManifold& manifold, const Eigen::VectorXd& gap, Eigen::VectorXd& lambda) {
  if (manifold.curved().empty()) return;
  constexpr int kSize = StateManifold::kBlockSize;
  std::vector<double> blocks(manifold.curved().size() * kSize), unused(blocks.size());
  const Eigen::VectorXd minus_gap = -gap;
  manifold.integrate_jacobians(minus_gap.data(), blocks.data(), unused.data());
  for (std::size_t s = 0; s < manifold.curved().size(); ++s) {
    const auto& segment = manifold.curved()[s];
    const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>
        block(blocks.data() + s * kSize, segment.n, segment.n);
    lambda.segment(segment.dx, segment.n) =
        (block.transpose() * lambda.segment(segment.dx, segment.n)).eval();
  }
}

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

/// Stationarity and complementarity by the adjoint pass.
void adjoint_pass(const ShootingProblem& problem, const Trajectory& trajectory,
                  const Linearization& linearization, double bound_tolerance, AnswerCheck& check) {
  const int N = problem.knots(), ndx = problem.ndx();
  check.stationarity = check.complementarity = 0;
  Eigen::VectorXd lambda = linearization.knots[N].gradient;
  Eigen::MatrixXd value = linearization.knots[N].hessian();
  for (int k = N - 1; k >= 0; --k) {
    const KnotLinearization& knot = linearization.knots[k];
    const KnotModel& model = *problem.knot(k).model;
    const Eigen::MatrixXd jacobian = knot.dense_jacobian();
    transport(problem.manifold(), linearization.gap.col(k), lambda);
    const Eigen::VectorXd gradient = knot.gradient + jacobian.transpose() * lambda;
    std::vector<int> free;
    for (int i = 0; i < problem.nu(k); ++i) {
      const double g = gradient[ndx + i];
      const BoundRelation bound = relate(model, i, trajectory.u(k)[i], g, bound_tolerance);
      if (!bound.near) free.push_back(i);
      if (bound.distance)
        check.complementarity = std::max(check.complementarity, std::abs(g) * *bound.distance);
      else
        check.stationarity = std::max(check.stationarity, std::abs(g));
    }
    const Eigen::MatrixXd K = riccati_step(knot.hessian(), jacobian, free, value);
    lambda = gradient.head(ndx) + K.transpose() * gradient.tail(problem.nu(k));
  }
}

}  // namespace

AnswerCheck check_answer(const ShootingProblem& problem, const Trajectory& trajectory,
                         double bound_tolerance, const Eigen::VectorXd& constraint_multipliers) {
  AnswerCheck check;
  Acts acts(problem);
  Linearization linearization(problem);
  Augmentation lagrangian(problem);
  const bool multipliers_known = constraint_multipliers.size() == problem.constraint_rows();
  if (multipliers_known) lagrangian.multiplier = constraint_multipliers;
  acts.differentiate(trajectory, linearization, &lagrangian);
  const auto finite = [](const KnotLinearization& knot) {
    return knot.gradient.allFinite() && knot.hessian().allFinite() && knot.F.allFinite();
  };
  if (!linearization.cost.allFinite() || !linearization.gap.allFinite() ||
      !std::all_of(linearization.knots.begin(), linearization.knots.end(), finite))
    return check;
  check.cost = linearization.total_cost() + linear_soft_cost(problem, linearization.constraint);
  Eigen::VectorXd start(problem.ndx());
  problem.manifold().difference(problem.initial_state().data(), trajectory.x(0).data(),
                                start.data());
  check.gap = std::max(linearization.max_gap(), start.lpNorm<Eigen::Infinity>());
  check.constraint = bound_violation(problem, trajectory);
  for (const ConstraintViolation& violation : violations_by_name(problem, linearization.constraint))
    check.constraint = std::max(check.constraint, violation.value);
  if (!multipliers_known) return check;
  adjoint_pass(problem, trajectory, linearization, bound_tolerance, check);
  for (const NodeConstraint& c : problem.constraints())
    check.complementarity =
        std::max(check.complementarity, complementarity(c, linearization.constraint.data() + c.row,
                                                        constraint_multipliers.data() + c.row));
  return check;
}

}  // namespace conddp
