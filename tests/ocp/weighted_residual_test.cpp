#include "ocp/residuals/weighted_residual.hpp"

#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

#include "support/contact_case.hpp"
#include "support/knot_case.hpp"
#include "support/second_derivatives.hpp"

namespace conddp {
namespace {

/// Symmetric, positive semidefinite, of this rank.
Eigen::MatrixXd random_weights(int n, int rank, RandomNumbers& random) {
  Eigen::MatrixXd half(n, rank);
  for (double& entry : half.reshaped()) entry = random.uniform(-1, 1);
  return (half * half.transpose()).eval().selfadjointView<Eigen::Lower>();
}

/// Terminal node of a system with one state cost.
KnotCase state_case(const std::shared_ptr<const System>& system, const Eigen::MatrixXd* matrix,
                    Activation activation = {}) {
  auto model = std::make_shared<KnotModel>(system, Integrator::none);
  auto residual = state_residual(model->manifold());
  if (matrix) residual = weighted_residual(residual, *matrix);
  model->add_cost("state", residual, std::move(activation));
  RandomNumbers random(5);
  return make_case("state", model, random);
}

struct Differentiated {
  double cost;
  Eigen::VectorXd gradient;
  Eigen::MatrixXd hessian;
};

Differentiated differentiate(const KnotCase& c) {
  KnotWorkspace<double> work(*c.model);
  c.model->differentiate(KnotInput<double>{c.x.data(), nullptr, c.parameters.data(), 0.0, 1.0},
                         work, true);
  const int nz = c.model->nz();
  Differentiated result{work.cost, Eigen::Map<const Eigen::VectorXd>(work.gradient.data(), nz),
                        Eigen::MatrixXd::Zero(nz, nz)};
  const auto& pattern = c.model->hessian_pattern();
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    const auto [row, column] = pattern[i];
    result.hessian(row, column) = result.hessian(column, row) = work.hessian[i];
  }
  return result;
}

/// x ⊖ reference and its derivative with respect to x, for a terminal node with the state residual.
std::pair<Eigen::VectorXd, Eigen::MatrixXd> state_difference(const KnotCase& c) {
  const KnotModel& model = *c.model;
  const auto residual = state_residual(model.manifold());
  const auto data = model.system().create_data(0.0);
  model.system().update_kinematics(c.x.data(), *data);
  Eigen::VectorXd r(residual->size());
  std::vector<double> packed(residual->jacobian_size());
  residual->differentiate(ResidualInput<double>{c.x.data(), nullptr, c.parameters.data(), *data},
                          r.data(), packed.data());
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(r.size(), model.ndx());
  const double* entry = packed.data();
  int row = 0;
  for (const RowBlock& block : residual->blocks()) {
    for (const int column : block.columns)
      for (int i = 0; i < block.rows; ++i) J(row + i, column) = *entry++;
    row += block.rows;
  }
  return {r, J};
}

TEST(WeightedResidual, CostIsHalfTheMatrixSquare) {
  RandomNumbers random(11);
  for (const auto& [name, system] : test_systems()) {
    const int n = system->ndx();
    for (const int rank : {1, n}) {
      const Eigen::MatrixXd W = random_weights(n, rank, random);
      const KnotCase c = state_case(system, &W);
      const auto [r, J] = state_difference(c);
      const double weight = c.parameters.back();
      const Differentiated got = differentiate(c);
      const double scale = 1 + W.cwiseAbs().maxCoeff() * (1 + r.squaredNorm());
      EXPECT_NEAR(got.cost, weight * 0.5 * r.dot(W * r), 1e-12 * scale) << name;
      EXPECT_LT((got.gradient - weight * J.transpose() * W * r).cwiseAbs().maxCoeff(),
                1e-11 * scale)
          << name;
      EXPECT_LT((got.hessian - weight * J.transpose() * W * J).cwiseAbs().maxCoeff(), 1e-11 * scale)
          << name;
    }
  }
}

TEST(WeightedResidual, DiagonalMatrixMatchesWeights) {
  for (const auto& [name, system] : test_systems()) {
    const int n = system->ndx();
    std::vector<double> weights(n);
    for (int i = 0; i < n; ++i) weights[i] = i % 3 == 1 ? 0 : 0.5 + i;
    const Eigen::MatrixXd W =
        Eigen::Map<const Eigen::VectorXd>(weights.data(), n).asDiagonal().toDenseMatrix();
    const Differentiated a = differentiate(state_case(system, &W));
    const Differentiated b = differentiate(state_case(system, nullptr, {.weights = weights}));
    EXPECT_NEAR(a.cost, b.cost, 1e-12 * (1 + b.cost)) << name;
    EXPECT_LT((a.gradient - b.gradient).cwiseAbs().maxCoeff(), 1e-10) << name;
    EXPECT_LT((a.hessian - b.hessian).cwiseAbs().maxCoeff(), 1e-10) << name;
  }
}

TEST(WeightedResidual, PartwiseExactHessiansMatchDualNumbers) {
  RandomNumbers random(12);
  const auto cases = contact_cases();
  const auto contact = std::find_if(cases.begin(), cases.end(), [](const ContactCase& c) {
    return c.contacts.front().kind == ContactKind::point && c.robot->joint_count() > 5;
  });
  ASSERT_NE(contact, cases.end());
  auto robot = std::make_shared<RobotModel>(*contact->robot);
  robot->wrenches.clear();
  const auto system = std::make_shared<MultibodySystem>(robot, Actuation::full(*robot),
                                                        PassiveForces{}, contact->contacts);
  auto model = std::make_shared<KnotModel>(system, Integrator::semi_implicit_euler);
  const int n = model->ndx();
  model->add_cost(
      "state", weighted_residual(state_residual(model->manifold()), random_weights(n, n, random)),
      {});
  model->add_cost(
      "com", weighted_residual(com_position_residual(system), random_weights(3, 2, random)), {});
  model->add_cost(
      "force",
      weighted_residual(contact_force_residual(system, 0, n), random_weights(3, 3, random)), {});
  ASSERT_TRUE(known_by_parts(*model));
  const KnotCase knot = make_case("weighted", model, random);
  const ShootingProblem problem = problem_of(knot, kLaneWidth + 1);
  Trajectory t = problem.create_trajectory();
  for (int k = 0; k < problem.knots(); ++k)
    for (double& u : t.u(k)) u = random.uniform(-1, 1);
  expect_hessians_of_dual_numbers(problem, t, Augmentation(problem), random);
}

TEST(WeightedResidual, UncoupledRowsStaySeparate) {
  const auto system = double_integrator(2);
  const KnotModel model(system, Integrator::none);
  Eigen::MatrixXd W = Eigen::MatrixXd::Identity(4, 4);
  W(0, 2) = W(2, 0) = 0.5;
  const auto residual = weighted_residual(state_residual(model.manifold()), W);
  ASSERT_EQ(residual->blocks().size(), 3u);
  EXPECT_EQ(residual->blocks()[0].columns, (std::vector<int>{0, 2}));
  EXPECT_EQ(residual->blocks()[0].rows, 2);
  EXPECT_EQ(residual->blocks()[1].columns, (std::vector<int>{1}));
  EXPECT_TRUE(residual->blocks()[2].affine);
}

TEST(WeightedResidual, ZeroMatrixCostsNothing) {
  const auto system = double_integrator(1);
  const Eigen::MatrixXd W = Eigen::MatrixXd::Zero(2, 2);
  const Differentiated got = differentiate(state_case(system, &W));
  EXPECT_EQ(got.cost, 0);
  EXPECT_TRUE(got.gradient.isZero(0));
}

TEST(WeightedResidual, InvalidWeightMatricesAreErrors) {
  const auto residual = state_residual(StateManifold::flat(2));
  EXPECT_THROW(weighted_residual(residual, Eigen::Matrix2d{{1, 2}, {2, 1}}), std::invalid_argument);
  EXPECT_THROW(weighted_residual(residual, Eigen::Matrix2d{{1, 0.5}, {0, 1}}),
               std::invalid_argument);
  EXPECT_THROW(weighted_residual(residual, Eigen::Matrix2d{{1, 1}, {1, 0}}), std::invalid_argument);
  EXPECT_THROW(weighted_residual(residual, Eigen::Matrix3d::Identity()), std::invalid_argument);
}

TEST(WeightedResidual, FactorsOfBadlyScaledMatricesAreExact) {
  const Eigen::Matrix2d C{{1, 0.5}, {0.5, 1}};
  const Eigen::Vector2d scale(1e8, 1e-6);
  const Eigen::Matrix2d W = scale.asDiagonal() * C * scale.asDiagonal();
  const Eigen::MatrixXd L = weight_factor(W);
  const Eigen::Matrix2d again = L * L.transpose();
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(again(i), W(i), 1e-14 * std::abs(W(i)));
}

TEST(WeightedResidual, BadDiagonalHasNoScaledEigenvalue) {
  const double none = -std::numeric_limits<double>::infinity();
  EXPECT_EQ(least_scaled_eigenvalue(Eigen::Matrix2d{{0, 1}, {1, 2}}), none);
  EXPECT_EQ(least_scaled_eigenvalue(Eigen::Matrix2d{{-1, 0}, {0, 2}}), none);
  EXPECT_EQ(least_scaled_eigenvalue(Eigen::Matrix2d{{0, 0}, {0, 4}}), 0);
  EXPECT_NEAR(least_scaled_eigenvalue(Eigen::Matrix2d{{4, 1}, {1, 1}}), 0.5, 1e-15);
}

}  // namespace
}  // namespace conddp
