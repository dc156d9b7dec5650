#include "analysis/certificate/lagrangian_gradient.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "analysis/certificate/small_matrices.hpp"

namespace conddp {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The number with a random sign.
double with_random_sign(std::mt19937_64& engine, double number) {
  return (engine() >> 63) != 0 ? number : -number;
}

/// Bounds that a control is at or beyond.
struct ControlAtBounds {
  ControlAtBounds(const KnotModel& model, int i, double u, double tolerance) {
    const double low = model.control_lower()[i], high = model.control_upper()[i];
    lower = u <= low + tolerance * std::max(1.0, std::abs(low));
    upper = u >= high - tolerance * std::max(1.0, std::abs(high));
  }
  bool lower, upper;
};

/// Rows of a step's Jacobian that follow from others. With q⁺ = q + h v⁺, those of q do: row i is h
/// times another one, plus 1 in column i.
class StepRows {
 public:
  using Index = Eigen::Index;
  struct Kept {
    Index row;
    Index follower;  ///< the row that follows from it, or −1
  };

  void find(const KnotModel& model, double h, const MatrixXd& jacobian) {
    h_ = h;
    kept_.clear();
    followers_.clear();
    const Index nv = model.semi_implicit() ? model.jacobian_rows() : 0;
    for (Index i = 0; i < nv; ++i)
      if (is_flat(model.manifold(), i) && follows(i, nv + i, jacobian))
        followers_.push_back(i);
      else
        kept_.push_back({i, -1});
    auto follower = followers_.begin();
    for (Index i = nv; i < jacobian.rows(); ++i)
      kept_.push_back({i, follower != followers_.end() && *follower == i - nv ? *follower++ : -1});
  }

  double h() const { return h_; }
  /// Both in ascending order.
  const std::vector<Kept>& kept() const { return kept_; }
  const std::vector<Index>& followers() const { return followers_; }

 private:
  static bool is_flat(const StateManifold& manifold, Index row) {
    return std::ranges::none_of(manifold.curved(), [row](const StateManifold::Segment& s) {
      return row >= s.dx && row < s.dx + s.n;
    });
  }
  bool follows(Index row, Index from, const MatrixXd& jacobian) const {
    constexpr double kSame = 1e-14;
    for (Index c = 0; c < jacobian.cols(); ++c) {
      const double entry = h_ * jacobian(from, c) + (c == row ? 1 : 0);
      if (!(std::abs(jacobian(row, c) - entry) <= kSame * std::max(1.0, std::abs(entry))))
        return false;
    }
    return true;
  }

  double h_ = 0;
  std::vector<Kept> kept_;
  std::vector<Index> followers_;
};

/// Stages of a policy, from the last to the first; each uses the value of the next node.
class RiccatiStep {
 public:
  /// Q of a stage, Hessian + Jᵀ V J, with J = S R + E. R contains the rows of J that `rows` keeps,
  /// and E the unit entries of the rows that follow from them.
  void form(const MatrixXd& value, const MatrixXd& hessian, const MatrixXd& jacobian,
            const StepRows& rows, MatrixXd& Q) {
    const Index ndx = jacobian.rows(), nz = jacobian.cols();
    const auto count = static_cast<Index>(rows.kept().size());
    kept_.resize(count, nz);
    weight_.resize(ndx, count);
    pulled_.resize(count, nz);
    for (Index c = 0; c < nz; ++c)
      for (Index r = 0; r < count; ++r) kept_(r, c) = jacobian(rows.kept()[r].row, c);
    for (Index r = 0; r < count; ++r) {
      const auto& [row, follower] = rows.kept()[r];
      weight_.col(r) = value.col(row);
      if (follower >= 0) weight_.col(r) += rows.h() * value.col(follower);
    }
    multiply(weight_, kept_, moved_);
    for (const Index i : rows.followers()) moved_.col(i) += value.col(i);
    for (Index c = 0; c < nz; ++c)
      for (Index r = 0; r < count; ++r) {
        const auto& [row, follower] = rows.kept()[r];
        pulled_(r, c) = moved_(row, c);
        if (follower >= 0) pulled_(r, c) += rows.h() * moved_(follower, c);
      }
    transposed_ = kept_.transpose();
    multiply_lower(transposed_, pulled_, Q);
    for (Index c = 0; c < nz; ++c)
      for (const Index i : rows.followers())
        if (i >= c) Q(i, c) += moved_(i, c);
    Q += hessian;
    mirror_lower_triangle(Q);
  }

  /// Minimizes over the free controls. Returns false if the stage is not convex; K is then zero.
  bool minimize(const MatrixXd& Q, const std::vector<int>& free, MatrixXd& K, MatrixXd& inverse) {
    K.setZero();
    inverse.setZero();
    const Index nu = K.rows(), ndx = K.cols(), count = static_cast<Index>(free.size());
    if (free.empty()) return true;
    block_ = Q.bottomRightCorner(nu, nu)(free, free);
    if (!factors_.factorize(block_, kLeastPivot)) return false;
    rows_.resize(count, ndx + count);
    rows_.leftCols(ndx) = Q.bottomLeftCorner(nu, ndx)(free, Eigen::all);
    rows_.rightCols(count).setIdentity();
    factors_.solve(rows_);
    K(free, Eigen::all) = -rows_.leftCols(ndx);
    inverse(free, free) = rows_.rightCols(count);
    return true;
  }

  /// The Hessian of the cost to go along K: Q_xx + Kᵀ Q_uu K + Kᵀ Q_ux + Q_xu K.
  void propagate(const MatrixXd& Q, const MatrixXd& K, MatrixXd& value) {
    const Index nu = K.rows(), ndx = K.cols();
    multiply(Q.bottomRightCorner(nu, nu), K, controls_moved_);
    controls_moved_ += 2 * Q.bottomLeftCorner(nu, ndx);
    transposed_gains_ = K.transpose();
    multiply(transposed_gains_, controls_moved_, along_);
    along_ += Q.topLeftCorner(ndx, ndx);
    value = 0.5 * (along_ + along_.transpose());
  }

 private:
  using Index = Eigen::Index;
  /// Smallest pivot of a block that is positive definite beyond rounding, relative to its diagonal.
  static constexpr double kLeastPivot = 1e-14;

  SmallCholesky factors_;
  SmallCholesky::Rows rows_;
  MatrixXd kept_, weight_, moved_, pulled_, transposed_;  // workspace of form()
  MatrixXd block_;                                        // workspace of minimize()
  MatrixXd controls_moved_, transposed_gains_, along_;    // workspace of propagate()
};

}  // namespace

LagrangianGradient lagrangian_gradient(const ShootingProblem& problem,
                                       const std::vector<NodeDerivatives>& derivatives,
                                       const Eigen::MatrixXd& costates,
                                       const Eigen::VectorXd& multipliers) {
  const int N = problem.knots(), ndx = problem.ndx();
  LagrangianGradient out{-costates, {}, costates.cwiseAbs(), {}};
  NodeGradient node;
  for (int k = 0; k <= N; ++k) {
    node_gradient(problem, derivatives[k], k, multipliers,
                  k < N ? costates.col(k + 1).data() : nullptr, node);
    if (k < N) {
      out.control.emplace_back(node.value.tail(problem.nu(k)));
      out.control_size.emplace_back(node.size.tail(problem.nu(k)));
    }
    out.state.col(k) += node.value.head(ndx);
    out.state_size.col(k) += node.size.head(ndx);
  }
  return out;
}

void node_gradient(const ShootingProblem& problem, const NodeDerivatives& derivatives, int node,
                   const Eigen::VectorXd& multipliers, const double* next, NodeGradient& out) {
  out.value = derivatives.cost;
  out.size = derivatives.cost.cwiseAbs();
  add_transposed_product(derivatives.constraint,
                         multipliers.data() + problem.constraint_offset(node), out.value, out.size);
  if (next != nullptr) add_transposed_product(derivatives.step, next, out.value, out.size);
}

AdjointPass adjoint_pass(const ShootingProblem& problem,
                         const std::vector<NodeDerivatives>& derivatives,
                         const VectorXd& multipliers, const std::vector<MatrixXd>& gains) {
  const int N = problem.knots(), ndx = problem.ndx();
  AdjointPass pass{MatrixXd(ndx, N + 1), std::vector<VectorXd>(N), 0};
  std::mt19937_64 engine(3);
  VectorXd error = VectorXd::Zero(ndx), moved;
  NodeGradient node;
  for (int k = N; k >= 0; --k) {
    const NodeDerivatives& d = derivatives[k];
    node_gradient(problem, d, k, multipliers, k < N ? pass.costates.col(k + 1).data() : nullptr,
                  node);
    moved = kAdjointRounding * node.size;
    for (double& entry : moved) entry = with_random_sign(engine, entry);
    if (k < N) moved.noalias() += d.step.transpose() * error;
    pass.costates.col(k) = node.value.head(ndx);
    error = moved.head(ndx);
    if (k == N) continue;
    pass.control[k] = node.value.tail(problem.nu(k));
    const auto change = moved.tail(problem.nu(k));
    if (change.size() > 0)
      pass.rounding = std::max(pass.rounding, change.lpNorm<Eigen::Infinity>());
    if (gains.empty()) continue;
    pass.costates.col(k).noalias() += gains[k].transpose() * pass.control[k];
    error.noalias() += gains[k].transpose() * change;
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

RiccatiPolicy::RiccatiPolicy(const ShootingProblem& problem) : K(problem.knots()), inverse(K) {
  for (int k = 0; k < problem.knots(); ++k) {
    K[k].resize(problem.nu(k), problem.ndx());
    inverse[k].resize(problem.nu(k), problem.nu(k));
  }
}

RiccatiPolicy riccati_policy(const ShootingProblem& problem, const Trajectory& trajectory,
                             const std::vector<NodeDerivatives>& derivatives,
                             const std::vector<MatrixXd>& hessians, double bound_tolerance) {
  const int N = problem.knots();
  RiccatiPolicy policy(problem);
  MatrixXd Q, value = hessians[N];
  RiccatiStep step;
  StepRows rows;
  std::vector<int> free;
  for (int k = N - 1; k >= 0; --k) {
    free.clear();
    for (int i = 0; i < problem.nu(k); ++i) {
      const ControlAtBounds control(*problem.knot(k).model, i, trajectory.u(k)[i], bound_tolerance);
      if (!control.lower && !control.upper) free.push_back(i);
    }
    rows.find(*problem.knot(k).model, problem.knot(k).dt, derivatives[k].step);
    step.form(value, hessians[k], derivatives[k].step, rows, Q);
    policy.convex &= step.minimize(Q, free, policy.K[k], policy.inverse[k]);
    step.propagate(Q, policy.K[k], value);
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
