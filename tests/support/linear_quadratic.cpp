#include "support/linear_quadratic.hpp"

#include <random>

namespace conddp::testing {

LinearQuadratic::LinearQuadratic(unsigned seed, int nx_, std::vector<int> nu, int knots_per_phase,
                                 double low, double up, double spectral_radius)
    : nx(nx_) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> positive(0.1, 2);
  const auto matrix = [&](int r, int c) {
    return Eigen::MatrixXd::NullaryExpr(r, c, [&] { return normal(engine); }).eval();
  };
  const auto weights = [&](int n) {
    return Eigen::VectorXd::NullaryExpr(n, [&] { return positive(engine); }).eval();
  };
  const auto plain = [](const Eigen::VectorXd& v) {
    return std::vector<double>(v.data(), v.data() + v.size());
  };
  x0 = matrix(nx, 1);
  std::vector<Phase> phases;
  for (std::size_t p = 0; p < nu.size(); ++p) {
    Knot knot;
    knot.A = Eigen::MatrixXd::Identity(nx, nx) + 0.2 * matrix(nx, nx);
    if (spectral_radius > 0) knot.A *= spectral_radius / knot.A.eigenvalues().cwiseAbs().maxCoeff();
    knot.B = matrix(nx, nu[p]);
    knot.c = 0.3 * matrix(nx, 1);
    const Eigen::VectorXd q = weights(nx), r = weights(nu[p]);
    knot.x_ref = matrix(nx, 1);
    const double dt = 0.25;
    knot.Q = dt * q;
    knot.R = dt * r;
    phases.push_back(tracking_phase(
        linear_system(knot.A, knot.B, knot.c), Integrator::discrete, knots_per_phase, dt,
        {plain(knot.x_ref), plain(q), plain(r), {}}, low, up, "phase" + std::to_string(p)));
    knots.insert(knots.end(), knots_per_phase, knot);
  }
  Qf = weights(nx);
  xf_ref = matrix(nx, 1);
  Phase end =
      terminal_phase(phases.back().model->shared_system(), {plain(xf_ref), {}, {}, plain(Qf)});
  problem = std::make_unique<ShootingProblem>(plain(x0), std::move(phases), std::move(end));
}

double LinearQuadratic::cost(const Trajectory& t) const {
  double sum = 0;
  for (int k = 0; k < N(); ++k) {
    const Eigen::VectorXd dx = t.x(k) - knots[k].x_ref;
    sum += 0.5 * dx.dot(knots[k].Q.asDiagonal() * dx) +
           0.5 * t.u(k).dot(knots[k].R.asDiagonal() * t.u(k));
  }
  const Eigen::VectorXd dx = t.x(N()) - xf_ref;
  return sum + 0.5 * dx.dot(Qf.asDiagonal() * dx);
}

Trajectory LinearQuadratic::dense_optimum(Eigen::MatrixXd* multipliers) const {
  std::vector<int> u_at;
  int n = N() * nx;
  for (const Knot& knot : knots) {
    u_at.push_back(n);
    n += static_cast<int>(knot.B.cols());
  }
  const int m = N() * nx;
  const auto x_at = [this](int k) { return (k - 1) * nx; };
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n + m, n + m);
  Eigen::VectorXd rhs = Eigen::VectorXd::Zero(n + m);
  for (int k = 0; k < N(); ++k) {
    const Knot& knot = knots[k];
    const int nu = static_cast<int>(knot.B.cols());
    if (k > 0) {
      K.block(x_at(k), x_at(k), nx, nx) = knot.Q.asDiagonal();
      rhs.segment(x_at(k), nx) = knot.Q.cwiseProduct(knot.x_ref);
      K.block(n + k * nx, x_at(k), nx, nx) = knot.A;
    } else {
      rhs.segment(n, nx) -= knot.A * x0;
    }
    K.block(u_at[k], u_at[k], nu, nu) = knot.R.asDiagonal();
    K.block(n + k * nx, u_at[k], nx, nu) = knot.B;
    K.block(n + k * nx, x_at(k + 1), nx, nx) = -Eigen::MatrixXd::Identity(nx, nx);
    rhs.segment(n + k * nx, nx) -= knot.c;
  }
  K.block(x_at(N()), x_at(N()), nx, nx) = Qf.asDiagonal();
  rhs.segment(x_at(N()), nx) = Qf.cwiseProduct(xf_ref);
  K.topRightCorner(n, m) = K.bottomLeftCorner(m, n).transpose();
  const Eigen::VectorXd z = K.fullPivLu().solve(rhs);
  Trajectory t = problem->create_trajectory();
  for (int k = 0; k < N(); ++k) {
    t.x(k + 1) = z.segment(x_at(k + 1), nx);
    t.u(k) = z.segment(u_at[k], knots[k].B.cols());
  }
  if (multipliers != nullptr) {
    multipliers->setZero(nx, N() + 1);
    for (int k = 0; k < N(); ++k) multipliers->col(k + 1) = z.segment(n + k * nx, nx);
  }
  return t;
}

std::vector<Eigen::MatrixXd> LinearQuadratic::riccati_gains() const {
  std::vector<Eigen::MatrixXd> gains(N());
  Eigen::MatrixXd P = Qf.asDiagonal();
  for (int k = N() - 1; k >= 0; --k) {
    const Eigen::MatrixXd &A = knots[k].A, &B = knots[k].B;
    const Eigen::MatrixXd R = knots[k].R.asDiagonal(), Q = knots[k].Q.asDiagonal();
    gains[k] = -(R + B.transpose() * P * B).fullPivLu().solve(B.transpose() * P * A);
    P = Q + A.transpose() * P * (A + B * gains[k]);
  }
  return gains;
}

void LinearQuadratic::condense(Eigen::MatrixXd& H, Eigen::VectorXd& g) const {
  int n = 0;
  for (const Knot& knot : knots) n += static_cast<int>(knot.B.cols());
  H.setZero(n, n);
  g.setZero(n);
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(nx, n);  // x_k = S U + s
  Eigen::VectorXd s = x0;
  int at = 0;
  for (int k = 0; k <= N(); ++k) {
    const Eigen::VectorXd& Q = k < N() ? knots[k].Q : Qf;
    const Eigen::VectorXd& ref = k < N() ? knots[k].x_ref : xf_ref;
    H += S.transpose() * Q.asDiagonal() * S;
    g += S.transpose() * Q.cwiseProduct(s - ref);
    if (k == N()) break;
    const int nu = static_cast<int>(knots[k].B.cols());
    H.block(at, at, nu, nu) += Eigen::MatrixXd(knots[k].R.asDiagonal());
    S = (knots[k].A * S).eval();
    S.middleCols(at, nu) += knots[k].B;
    s = (knots[k].A * s + knots[k].c).eval();
    at += nu;
  }
}

}  // namespace conddp::testing
