#include "analysis/certificate/reduced_gradient.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>

#include <Eigen/Cholesky>

namespace conddp {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// +1 or −1 for each entry.
VectorXd signs(std::mt19937_64& engine, Eigen::Index count) {
  VectorXd list(count);
  for (double& entry : list) entry = (engine() >> 63) != 0 ? 1 : -1;
  return list;
}

/// Which bounds a control stands at, or is beyond.
struct ControlAtBounds {
  ControlAtBounds(const KnotModel& model, int i, double u, double tolerance) {
    const double low = model.control_lower()[i], high = model.control_upper()[i];
    lower = u <= low + tolerance * std::max(1.0, std::abs(low));
    upper = u >= high - tolerance * std::max(1.0, std::abs(high));
  }
  bool lower, upper;
};

/// None where it is not positive definite to rounding.
std::optional<Eigen::LLT<MatrixXd>> factored(const MatrixXd& block) {
  constexpr double kLeastPivot = 1e-14;
  const Eigen::LLT<MatrixXd> factors(block);
  if (factors.info() != Eigen::Success) return std::nullopt;
  const double least = factors.matrixLLT().diagonal().cwiseAbs2().minCoeff();
  if (!(least > kLeastPivot * block.diagonal().maxCoeff())) return std::nullopt;
  return factors;
}

/// The stage's minimum over the free controls, none where the stage is not `convex`. `value` is the
/// Hessian of the cost to go and becomes that of this node.
void riccati_step(const MatrixXd& hessian, const MatrixXd& jacobian, const std::vector<int>& free,
                  MatrixXd& value, MatrixXd& K, MatrixXd& inverse, bool& convex) {
  const Eigen::Index ndx = value.rows(), nu = hessian.rows() - ndx;
  const Eigen::Index count = static_cast<Eigen::Index>(free.size());
  const MatrixXd Q = hessian + jacobian.transpose() * value * jacobian;
  const auto Qzu = Q.rightCols(nu);
  const auto Quu = Qzu.bottomRows(nu);
  K = MatrixXd::Zero(nu, ndx);
  inverse = MatrixXd::Zero(nu, nu);
  if (count > 0) {
    const MatrixXd block = Quu(free, free);
    if (const auto factors = factored(block)) {
      const MatrixXd block_inverse = factors->solve(MatrixXd::Identity(count, count));
      const MatrixXd Qux = Qzu.topRows(ndx).transpose()(free, Eigen::all);
      const MatrixXd feedback = -factors->solve(Qux);
      inverse(free, free) = block_inverse;
      K(free, Eigen::all) = feedback;
    } else {
      convex = false;
    }
  }
  value = Q.topLeftCorner(ndx, ndx) + K.transpose() * Quu * K + Qzu.topRows(ndx) * K +
          (Qzu.topRows(ndx) * K).transpose();
  value = (0.5 * (value + value.transpose())).eval();
}

}  // namespace

AdjointPass adjoint_pass(const ShootingProblem& problem,
                         const std::vector<NodeDerivatives>& derivatives,
                         const VectorXd& multipliers, const std::vector<MatrixXd>& gains) {
  const int N = problem.knots(), ndx = problem.ndx();
  AdjointPass pass{MatrixXd(ndx, N + 1), std::vector<VectorXd>(N), 0};
  std::mt19937_64 engine(3);
  VectorXd error = VectorXd::Zero(ndx);
  for (int k = N; k >= 0; --k) {
    const NodeDerivatives& d = derivatives[k];
    const auto nu = multipliers.segment(problem.constraint_offset(k), d.constraint.rows());
    VectorXd gradient = d.cost + d.constraint.transpose() * nu;
    VectorXd size = d.cost.cwiseAbs() + d.constraint.cwiseAbs().transpose() * nu.cwiseAbs();
    VectorXd moved = VectorXd::Zero(d.cost.size());
    if (k < N) {
      gradient += d.step.transpose() * pass.costates.col(k + 1);
      size += d.step.cwiseAbs().transpose() * pass.costates.col(k + 1).cwiseAbs();
      moved = d.step.transpose() * error;
    }
    moved += kAdjointRounding * size.cwiseProduct(signs(engine, size.size()));
    pass.costates.col(k) = gradient.head(ndx);
    error = moved.head(ndx);
    if (k == N) continue;
    pass.control[k] = gradient.tail(problem.nu(k));
    const VectorXd change = moved.tail(problem.nu(k));
    if (change.size() > 0)
      pass.rounding = std::max(pass.rounding, change.lpNorm<Eigen::Infinity>());
    if (gains.empty()) continue;
    pass.costates.col(k) += gains[k].transpose() * pass.control[k];
    error += gains[k].transpose() * change;
  }
  return pass;
}

double RiccatiPolicy::decrease(const std::vector<VectorXd>& gradient) const {
  if (!convex) return std::numeric_limits<double>::quiet_NaN();
  double sum = 0;
  for (std::size_t k = 0; k < gradient.size(); ++k)
    sum += 0.5 * gradient[k].dot(inverse[k] * gradient[k]);
  return sum;
}

RiccatiPolicy riccati_policy(const ShootingProblem& problem, const Trajectory& trajectory,
                             const std::vector<NodeDerivatives>& derivatives,
                             const std::vector<MatrixXd>& hessians, double bound_tolerance) {
  const int N = problem.knots();
  RiccatiPolicy policy{std::vector<MatrixXd>(N), std::vector<MatrixXd>(N)};
  MatrixXd value = hessians[N];
  for (int k = N - 1; k >= 0; --k) {
    std::vector<int> free;
    for (int i = 0; i < problem.nu(k); ++i) {
      const ControlAtBounds control(*problem.knot(k).model, i, trajectory.u(k)[i], bound_tolerance);
      if (!control.lower && !control.upper) free.push_back(i);
    }
    riccati_step(hessians[k], derivatives[k].step, free, value, policy.K[k], policy.inverse[k],
                 policy.convex);
  }
  return policy;
}

ProjectedGradient project(const ShootingProblem& problem, const Trajectory& trajectory,
                          const std::vector<VectorXd>& gradient, double bound_tolerance) {
  ProjectedGradient out;
  for (int k = 0; k < problem.knots(); ++k)
    for (int i = 0; i < problem.nu(k); ++i) {
      const KnotModel& model = *problem.knot(k).model;
      const double g = gradient[k][i], u = trajectory.u(k)[i];
      const ControlAtBounds control(model, i, u, bound_tolerance);
      if (g > 0 && control.lower)
        out.product = std::max(out.product, g * std::abs(u - model.control_lower()[i]));
      else if (g < 0 && control.upper)
        out.product = std::max(out.product, -g * std::abs(u - model.control_upper()[i]));
      else if (!(std::abs(g) <= out.stationarity)) {
        out.stationarity = std::abs(g);
        out.knot = k;
        out.entry = i;
      }
    }
  return out;
}

}  // namespace conddp
