// Chosen initial states and periodic motions, compared with the dense KKT system of
// linear-quadratic problems.
#include <gtest/gtest.h>

#include "solvers/strategies/registry.hpp"
#include "support/constrained_problems.hpp"
#include "support/steps.hpp"
#include "systems/initial_choice.hpp"

namespace conddp {
namespace {

using testing::kFree;
using testing::LinearQuadratic;

/// Offset of the last state from the first, by coordinate.
using Link = std::vector<std::pair<int, double>>;

std::vector<double> plain(const Eigen::VectorXd& v) { return {v.data(), v.data() + v.size()}; }

/// The problem of `lq` with initial state x0 + u_0, |u_0| ≤ reach, and x_N − x_1 = offset for the
/// coordinates in `link`. Knot k of `lq` becomes knot k + 1.
ShootingProblem choosing(const LinearQuadratic& lq, double reach, const Link& link) {
  const int n = lq.nx;
  std::vector<int> all(n);
  std::vector<Column> names;
  for (int i = 0; i < n; ++i) all[i] = i, names.push_back({std::to_string(i), ""});
  const auto first = initial_choice(lq.problem->knot(0).model->system(), all, names);
  auto choice =
      std::make_shared<KnotModel>(step_with(first, Integrator::explicit_euler, Memory::previous));
  choice->set_control_bounds(std::vector<double>(n, -reach), std::vector<double>(n, reach));
  std::vector<Phase> phases{{.name = "start",
                             .model = choice,
                             .dt = {1.0},
                             .cost_scale = {1.0},
                             .parameters = {},
                             .instant = true}};
  // `scaled` weights include the knot's dt.
  const auto make = [&](const KnotModel& of, Integrator rule, const Eigen::VectorXd& reference,
                        const Eigen::VectorXd& Q, const Eigen::VectorXd& R) {
    auto model = std::make_shared<KnotModel>(step_with(of.shared_system(), rule, Memory::none, n));
    Phase phase{.name = "knot", .dt = {0.25}, .cost_scale = {1.0}};
    if (rule == Integrator::none) phase.dt = {0.0};
    phase.parameters = plain(reference);
    phase.parameters.push_back(1);
    model->add_cost("state", coordinate_residual(model->manifold(), all), {.weights = plain(Q)});
    if (rule != Integrator::none) {
      model->add_cost("control", control_residual(model->ndx(), model->nu()),
                      {.weights = plain(R)});
      phase.parameters.insert(phase.parameters.end(), model->nu(), 0.0);
      phase.parameters.push_back(1);
    }
    phase.model = std::move(model);
    return phase;
  };
  for (int k = 0; k < lq.N(); ++k)
    phases.push_back(make(*lq.problem->knot(k).model, Integrator::discrete, lq.knots[k].x_ref,
                          lq.knots[k].Q, lq.knots[k].R));
  Phase end = make(*lq.problem->knot(lq.N() - 1).model, Integrator::none, lq.xf_ref, lq.Qf, lq.Qf);
  if (!link.empty()) {
    std::vector<double> offset(n, 0.0), low(n, -kFree), up(n, kFree);
    for (const auto& [i, by] : link) offset[i] = by, low[i] = up[i] = 0;
    auto model = std::make_shared<KnotModel>(*end.model);
    model->add_constraint(make_constraint(
        "cycle", cycle_residual(StateManifold::flat(n), {plain(lq.x0), all}, offset),
        ConstraintKind::bounds));
    for (const auto& part : {low, up})
      end.parameters.insert(end.parameters.end(), part.begin(), part.end());
    end.parameters.push_back(1);
    end.model = std::move(model);
  }
  std::vector<double> start = plain(lq.x0);
  start.resize(2 * n, 0.0);
  return ShootingProblem(std::move(start), std::move(phases), std::move(end));
}

struct DenseAnswer {
  Eigen::MatrixXd x;            ///< one column per state, the chosen one first
  Eigen::VectorXd start, link;  ///< multipliers of fixed initial entries and of links
};

/// All states from the chosen one, with some initial entries fixed and the links enforced.
DenseAnswer dense(const LinearQuadratic& lq, const Link& fixed, const Link& link) {
  const int n = lq.nx, N = lq.N();
  std::vector<int> u_at;
  int size = (N + 1) * n;
  for (const auto& knot : lq.knots) {
    u_at.push_back(size);
    size += static_cast<int>(knot.B.cols());
  }
  const int f = static_cast<int>(fixed.size()), l = static_cast<int>(link.size());
  const int rows = N * n + f + l;
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(size + rows, size + rows);
  Eigen::VectorXd rhs = Eigen::VectorXd::Zero(size + rows);
  for (int k = 0; k <= N; ++k) {
    const Eigen::VectorXd& Q = k < N ? lq.knots[k].Q : lq.Qf;
    K.block(k * n, k * n, n, n) = Q.asDiagonal();
    rhs.segment(k * n, n) = Q.cwiseProduct(k < N ? lq.knots[k].x_ref : lq.xf_ref);
    if (k == N) break;
    const auto& knot = lq.knots[k];
    const int nu = static_cast<int>(knot.B.cols()), row = size + k * n;
    K.block(u_at[k], u_at[k], nu, nu) = knot.R.asDiagonal();
    K.block(row, k * n, n, n) = knot.A;
    K.block(row, u_at[k], n, nu) = knot.B;
    K.block(row, (k + 1) * n, n, n) = -Eigen::MatrixXd::Identity(n, n);
    rhs.segment(row, n) = -knot.c;
  }
  for (int i = 0; i < f; ++i) {
    K(size + N * n + i, fixed[i].first) = 1;
    rhs[size + N * n + i] = fixed[i].second;
  }
  for (int i = 0; i < l; ++i) {
    const int row = size + N * n + f + i;
    K(row, N * n + link[i].first) = 1;
    K(row, link[i].first) = -1;
    rhs[row] = link[i].second;
  }
  K.topRightCorner(size, rows) = K.bottomLeftCorner(rows, size).transpose();
  const Eigen::VectorXd z = K.fullPivLu().solve(rhs);
  return {Eigen::Map<const Eigen::MatrixXd>(z.data(), n, N + 1), z.segment(size + N * n, f),
          z.tail(l)};
}

double distance(const SolveResult& result, const DenseAnswer& answer) {
  double worst = 0;
  const Eigen::Index n = answer.x.rows();
  for (Eigen::Index k = 0; k < answer.x.cols(); ++k)
    worst = std::max(worst, (result.trajectory.x(static_cast<int>(k) + 1).head(n) - answer.x.col(k))
                                .lpNorm<Eigen::Infinity>());
  return worst;
}

TEST(ChosenStart, FreeChoiceMatchesDenseOptimum) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const LinearQuadratic lq(seed, 4, {3, 2}, 6, -kFree, kFree);
    const ShootingProblem problem = choosing(lq, kFree, {});
    const DenseAnswer expected = dense(lq, {}, {});
    for (const SolverInfo& solver : solvers()) {
      const SolveResult result =
          solve(problem, solver, testing::tight_options(), problem.create_trajectory());
      SCOPED_TRACE(std::string(solver.name) + ": " + result.message);
      EXPECT_EQ(result.status, SolveStatus::converged);
      EXPECT_LT(distance(result, expected), 1e-8);
    }
  }
}

TEST(ChosenStart, BoundedChoiceMatchesDenseOptimum) {
  const LinearQuadratic lq(5, 4, {3, 2}, 6, -kFree, kFree);
  const Eigen::VectorXd free = dense(lq, {}, {}).x.col(0) - lq.x0;
  Eigen::Index furthest = 0;
  const double reach = 0.9 * free.cwiseAbs().maxCoeff(&furthest);
  const double side = free[furthest] > 0 ? 1 : -1;
  const int i = static_cast<int>(furthest);
  const DenseAnswer expected = dense(lq, {{i, lq.x0[i] + side * reach}}, {});
  ASSERT_GT(side * expected.start[0], 0) << "it would go further";
  const Eigen::VectorXd off = expected.x.col(0) - lq.x0;
  for (int j = 0; j < 4; ++j) ASSERT_LE(std::abs(off[j]), reach * (1 + 1e-12));
  const ShootingProblem problem = choosing(lq, reach, {});
  for (const char* name : {"box_ddp", "box_fddp", "altro", "proxddp", "ipopt"}) {
    const SolveResult result =
        solve(problem, name, testing::tight_options(), problem.create_trajectory());
    SCOPED_TRACE(std::string(name) + ": " + result.message);
    EXPECT_EQ(result.status, SolveStatus::converged);
    EXPECT_LT(distance(result, expected), 1e-8);
    EXPECT_NEAR(result.control_gradient[0][i], -expected.start[0], 1e-7);
  }
}

TEST(ChosenStart, PeriodicMotionMatchesDenseOptimumAndMultipliers) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const LinearQuadratic lq(seed, 4, {3, 2}, 6, -kFree, kFree);
    // All or some coordinates, displaced by one.
    for (const Link& link : {Link{{0, 0}, {1, 0}, {2, 0}, {3, 0}}, Link{{1, 0.7}, {3, 0}}}) {
      const ShootingProblem problem = choosing(lq, kFree, link);
      const DenseAnswer expected = dense(lq, {}, link);
      for (const char* name : {"intro", "altro", "proxddp", "ipopt"}) {
        const SolveResult result =
            solve(problem, name, testing::tight_options(), problem.create_trajectory());
        SCOPED_TRACE(std::string(name) + ": " + result.message);
        EXPECT_EQ(result.status, SolveStatus::converged);
        EXPECT_LT(distance(result, expected), 1e-7);
        for (std::size_t i = 0; i < link.size(); ++i)
          EXPECT_NEAR(result.constraint_multipliers[link[i].first], expected.link[i], 1e-6);
      }
    }
  }
}

TEST(ChosenStart, PeriodicMotionNamesUnsupportedSolvers) {
  const LinearQuadratic lq(1, 3, {2}, 4, -kFree, kFree);
  const ShootingProblem problem = choosing(lq, kFree, {{0, 0}});
  const auto refusal = unsupported(*find_solver("box_fddp"), problem);
  ASSERT_TRUE(refusal);
  EXPECT_NE(refusal->find("'cycle'"), std::string::npos) << *refusal;
  EXPECT_NE(refusal->find("altro"), std::string::npos) << *refusal;
}

}  // namespace
}  // namespace conddp
