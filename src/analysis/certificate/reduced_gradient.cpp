#include "analysis/certificate/reduced_gradient.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <utility>

#include <Eigen/Cholesky>

#include "analysis/certificate/lagrangian_gradient.hpp"
#include "analysis/certificate/small_products.hpp"

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

/// Goes from node to node, from the end.
class RiccatiStep {
 public:
  /// `value` is the Hessian of the last node.
  explicit RiccatiStep(MatrixXd value) : value_(std::move(value)) {}

  /// The stage's minimum over the free controls; false where the stage is not convex.
  bool run(const MatrixXd& hessian, const MatrixXd& jacobian, const std::vector<int>& free,
           MatrixXd& K, MatrixXd& inverse) {
    multiply(value_, jacobian, moved_);
    transposed_ = jacobian.transpose();
    multiply(transposed_, moved_, Q_);
    Q_ += hessian;
    const Eigen::Index ndx = value_.rows(), nu = hessian.rows() - ndx;
    K = MatrixXd::Zero(nu, ndx);
    inverse = MatrixXd::Zero(nu, nu);
    const bool convex = minimize(free, K, inverse);
    propagate(K);
    return convex;
  }

 private:
  bool minimize(const std::vector<int>& free, MatrixXd& K, MatrixXd& inverse) const {
    if (free.empty()) return true;
    const Eigen::Index nu = K.rows(), count = static_cast<Eigen::Index>(free.size());
    const MatrixXd block = Q_.bottomRightCorner(nu, nu)(free, free);
    const auto factors = factored(block);
    if (!factors) return false;
    const MatrixXd Qux = Q_.topRightCorner(K.cols(), nu).transpose()(free, Eigen::all);
    const MatrixXd block_inverse = factors->solve(MatrixXd::Identity(count, count));
    const MatrixXd feedback = -factors->solve(Qux);
    inverse(free, free) = block_inverse;
    K(free, Eigen::all) = feedback;
    return true;
  }

  /// Makes `value_` the Hessian of this node's cost to go.
  void propagate(const MatrixXd& K) {
    const Eigen::Index nu = K.rows(), ndx = K.cols();
    multiply(Q_.bottomRightCorner(nu, nu), K, moved_);
    transposed_ = K.transpose();
    multiply(transposed_, moved_, along_);
    multiply(Q_.topRightCorner(ndx, nu), K, across_);
    value_ = Q_.topLeftCorner(ndx, ndx) + along_ + across_ + across_.transpose();
    value_ = (0.5 * (value_ + value_.transpose())).eval();
  }

  MatrixXd value_;
  MatrixXd Q_, moved_, transposed_, along_, across_;
};

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
    const auto [gradient, size] =
        node_gradient(problem, d, k, multipliers, k < N ? pass.costates.col(k + 1) : VectorXd());
    VectorXd moved = kAdjointRounding * size.cwiseProduct(signs(engine, size.size()));
    if (k < N) moved.noalias() += d.step.transpose() * error;
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
  RiccatiStep step(hessians[N]);
  for (int k = N - 1; k >= 0; --k) {
    std::vector<int> free;
    for (int i = 0; i < problem.nu(k); ++i) {
      const ControlAtBounds control(*problem.knot(k).model, i, trajectory.u(k)[i], bound_tolerance);
      if (!control.lower && !control.upper) free.push_back(i);
    }
    policy.convex &=
        step.run(hessians[k], derivatives[k].step, free, policy.K[k], policy.inverse[k]);
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
