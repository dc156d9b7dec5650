#include "support/conic_problems.hpp"

#include <cmath>
#include <random>
#include <string>

namespace conddp::testing {

ConicLinearQuadratic::ConicLinearQuadratic(unsigned seed, const ConicSize& size)
    : lq(seed, size.nx, {size.nu}, size.knots, -size.control, size.control, size.spectral_radius),
      control(size.control) {
  std::mt19937 engine(seed + 1000);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> share(0, 1);
  const auto matrix = [&](int r, int c, double scale) {
    return Eigen::MatrixXd::NullaryExpr(r, c, [&] { return scale * normal(engine); }).eval();
  };
  // A motion between the bounds.
  const int nx = size.nx, nu = size.nu, N = size.knots;
  const double most = std::isfinite(size.control) ? size.control : 1;
  std::vector<Eigen::VectorXd> z;
  Eigen::VectorXd x = lq.x0;
  for (int k = 0; k < N; ++k) {
    z.emplace_back(nx + nu);
    z.back() << x,
        (0.5 * most) * Eigen::VectorXd::NullaryExpr(nu, [&] { return 2 * share(engine) - 1; });
    x = lq.knots[k].A * x + lq.knots[k].B * z.back().tail(nu) + lq.knots[k].c;
  }
  const auto add = [&](const std::string& name, ConstraintKind kind, const Eigen::MatrixXd& C,
                       int first, int last, std::vector<double> lower, std::vector<double> upper,
                       double inside) {
    Added added{.name = name,
                .residual = std::make_shared<AffineResidual>(C, nx),
                .kind = kind,
                .reference = std::vector<double>(C.rows(), 0.0),
                .lower = std::move(lower),
                .upper = std::move(upper),
                .first = first,
                .last = last};
    for (int k = first; k <= last; ++k) {
      const Eigen::VectorXd at = k < N ? z[k] : x;
      Eigen::VectorXd value = C * at.head(C.cols());
      if (kind == ConstraintKind::second_order_cone) value[C.rows() - 1] -= inside * share(engine);
      added.references.emplace_back(value.data(), value.data() + value.size());
    }
    for (int copy = 0; copy < size.copies; ++copy) {
      constraints.push_back(added);
      constraints.back().name += std::string(copy, '\'');
    }
  };
  const double scale = 1 / std::sqrt(nx + nu);
  if (size.equalities > 0) {
    const std::vector<double> zero(size.equalities, 0.0);
    add("equal", ConstraintKind::bounds, matrix(size.equalities, nx + nu, scale), 1, N - 1, zero,
        zero, 0);
  }
  if (size.boxes > 0) {
    std::vector<double> lower(size.boxes), upper(size.boxes);
    for (double& bound : lower) bound = -size.slack * share(engine);
    for (double& bound : upper) bound = size.slack * share(engine);
    add("box", ConstraintKind::bounds, matrix(size.boxes, nx + nu, scale), 1, N - 1, lower, upper,
        0);
  }
  for (int i = 0; i < size.cones; ++i) {
    add("cone " + std::to_string(i), ConstraintKind::second_order_cone,
        matrix(size.cone_rows, nx + nu, scale), 1, N - 1, {}, {}, size.slack);
  }
  for (int i = 0; i < size.contradictions; ++i) {
    // The same rows equal to zero and to one.
    const Eigen::MatrixXd C = matrix(1, nx, scale);
    add("zero " + std::to_string(i), ConstraintKind::bounds, C, N, N, {0}, {0}, 0);
    add("one " + std::to_string(i), ConstraintKind::bounds, C, N, N, {1}, {1}, 0);
  }
  if (size.terminal > 0) {
    const std::vector<double> zero(size.terminal, 0.0);
    add("end", ConstraintKind::bounds, matrix(size.terminal, nx, 1 / std::sqrt(nx)), N, N, zero,
        zero, 0);
  }
  problem = std::make_unique<ShootingProblem>(with_constraints(*lq.problem, constraints));
}

}  // namespace conddp::testing
