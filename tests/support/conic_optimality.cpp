#include "support/conic_optimality.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "support/dense_convex.hpp"

namespace conddp::testing {

SolveResult solve_strictly(const ConicLinearQuadratic& conic, std::string_view solver) {
  SolverOptions options = tight_options();
  options.tolerances.stationarity = 1e-8;
  options.max_time_s = 500;
  return solve(*conic.problem, solver, options, conic.problem->create_trajectory());
}

double control_distance(const SolveResult& a, const SolveResult& b) {
  return (controls_of(a.trajectory) - controls_of(b.trajectory)).cwiseAbs().maxCoeff();
}

double optimality_error(const ConicLinearQuadratic& conic, const SolveResult& result) {
  const LinearQuadratic& lq = conic.lq;
  const Trajectory& t = result.trajectory;
  const int N = lq.N(), nx = lq.nx;
  double error = 0;
  const auto worst = [&](double e) { error = std::isfinite(e) ? std::max(error, e) : e; };
  std::vector<Eigen::VectorXd> push(N + 1);  // Cᵀν
  for (int k = 0; k <= N; ++k) push[k].setZero(nx + (k < N ? t.nu(k) : 0));
  for (const NodeConstraint& c : conic.problem->constraints()) {
    const auto added = std::find_if(conic.constraints.begin(), conic.constraints.end(),
                                    [&](const Added& a) { return a.name == c.term->name; });
    const Eigen::MatrixXd& C = static_cast<const AffineResidual&>(*added->residual).matrix();
    Eigen::VectorXd z(C.cols());
    z.head(nx) = t.x(c.node);
    if (C.cols() > nx) z.tail(C.cols() - nx) = t.u(c.node);
    const std::vector<double>& reference = added->references[c.node - added->first];
    const Eigen::VectorXd g = C * z - Eigen::Map<const Eigen::VectorXd>(reference.data(), C.rows());
    const Eigen::VectorXd nu = result.constraint_multipliers.segment(c.row, C.rows());
    push[c.node].head(C.cols()) += C.transpose() * nu;
    if (added->kind == ConstraintKind::second_order_cone) {
      const Eigen::Index n = g.size() - 1;
      worst(g.head(n).norm() - g[n]);
      worst(nu.head(n).norm() + nu[n]);
      worst(std::abs(nu.dot(g)));
      continue;
    }
    for (Eigen::Index i = 0; i < g.size(); ++i) {
      worst(added->lower[i] - g[i]);
      worst(g[i] - added->upper[i]);
      worst(std::abs(std::max(nu[i], 0.0) * (added->upper[i] - g[i])));
      worst(std::abs(std::min(nu[i], 0.0) * (g[i] - added->lower[i])));
    }
  }
  Eigen::VectorXd lambda = lq.Qf.cwiseProduct(t.x(N) - lq.xf_ref) + push[N];
  for (int k = N - 1; k >= 0; --k) {
    const LinearQuadratic::Knot& knot = lq.knots[k];
    const Eigen::VectorXd gap = knot.A * t.x(k) + knot.B * t.u(k) + knot.c - t.x(k + 1);
    worst(gap.cwiseAbs().maxCoeff());
    const Eigen::VectorXd gradient =
        knot.R.cwiseProduct(t.u(k)) + knot.B.transpose() * lambda + push[k].tail(t.nu(k));
    for (int i = 0; i < t.nu(k); ++i) {
      const double u = t.u(k)[i], most = conic.control;
      worst(std::abs(u) - most);
      if (u >= most)
        worst(gradient[i]);
      else if (u <= -most)
        worst(-gradient[i]);
      else
        worst(std::abs(gradient[i]));
    }
    lambda =
        (knot.Q.cwiseProduct(t.x(k) - knot.x_ref) + knot.A.transpose() * lambda + push[k].head(nx))
            .eval();
  }
  return error;
}

std::vector<SolveResult> expect_agreement(const ConicLinearQuadratic& conic,
                                          const std::vector<const char*>& solvers) {
  std::vector<SolveResult> results;
  for (const char* solver : solvers) {
    results.push_back(solve_strictly(conic, solver));
    EXPECT_EQ(results.back().status, SolveStatus::converged)
        << solver << ": " << results.back().message;
    EXPECT_LT(optimality_error(conic, results.back()), 1e-6) << solver;
    EXPECT_LT(control_distance(results.back(), results.front()), 1e-7) << solver;
  }
  return results;
}

void expect_answer(const ConicLinearQuadratic& conic, const char* solver) {
  const SolveResult result = solve_strictly(conic, solver);
  EXPECT_TRUE(controls_of(result.trajectory).allFinite()) << solver;
  EXPECT_TRUE(std::isfinite(result.cost)) << solver;
  EXPECT_NE(result.status, SolveStatus::time_limit) << solver << ": " << result.message;
  EXPECT_NE(result.status, SolveStatus::diverged) << solver << ": " << result.message;
}

}  // namespace conddp::testing
