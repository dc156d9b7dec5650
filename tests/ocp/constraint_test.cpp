#include "ocp/terms/constraint.hpp"

#include <gtest/gtest.h>

#include "ocp/evaluation/evaluator.hpp"
#include "ocp/problem/problem.hpp"
#include "ocp/residuals/expression_residual.hpp"
#include "support/knot_case.hpp"
#include "support/sizes.hpp"

namespace conddp {
namespace {

/// Points inside, outside, in the polar cone, on the axis, and at the tip of a cone of n rows.
std::vector<std::vector<double>> points(int n) {
  RandomNumbers random(3);
  std::vector<std::vector<double>> list;
  for (int i = 0; i < 40; ++i) list.push_back(random.numbers(n, 2));
  std::vector<double> axis(n, 0.0);
  for (const double t : {-1.0, 0.0, 1.0}) {
    axis[n - 1] = t;
    list.push_back(axis);
  }
  return list;
}

double tangential(const std::vector<double>& s) {
  return Eigen::Map<const Eigen::VectorXd>(s.data(), s.size() - 1).norm();
}

TEST(ConstraintSet, ConeProjectionIsMoreausDecomposition) {
  for (const int n : {2, 3, 5})
    for (const std::vector<double>& s : points(n)) {
      std::vector<double> p(n), inside(n);
      outside_cone(s.data(), n, p.data());
      double product = 0;
      for (int i = 0; i < n; ++i) {
        inside[i] = s[i] - p[i];
        product += p[i] * inside[i];
      }
      EXPECT_LE(tangential(inside), inside[n - 1] + 1e-14);
      EXPECT_LE(tangential(p), -p[n - 1] + 1e-14);
      EXPECT_NEAR(product, 0, 1e-14);
    }
}

TEST(ConstraintSet, ProjectionDerivativeMatchesDualNumbers) {
  using D = Dual<double>;
  const auto by_duals = [](const std::vector<double>& s, int direction) {
    std::vector<D> in(s.begin(), s.end()), out(s.size());
    in[direction].d = 1;
    // An independent evaluation of the cone formula at a point outside both cones.
    D sum(0.0);
    const int n = static_cast<int>(s.size());
    for (int i = 0; i + 1 < n; ++i) sum += in[i] * in[i];
    const D a = sqrt(sum), half = D(0.5) * (D(1.0) - in[n - 1] / a);
    for (int i = 0; i + 1 < n; ++i) out[i] = half * in[i];
    out[n - 1] = -(half * a);
    return out;
  };
  for (const int n : {2, 3, 5})
    for (const std::vector<double>& s : points(n)) {
      std::vector<double> derivative(n * n);
      outside_cone_derivative(s.data(), n, derivative.data());
      const double a = tangential(s), t = s.back();
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          const double expected = a <= t    ? 0.0
                                  : a <= -t ? (i == j ? 1.0 : 0.0)
                                            : by_duals(s, j)[i].d;
          EXPECT_NEAR(derivative[j * n + i], expected, 1e-13);
        }
    }
}

TEST(ConstraintSet, DistanceAndComplementarityIdentifySolutions) {
  const auto residual = control_residual(0, 3);
  const ConstraintTerm box = make_constraint("box", residual, ConstraintKind::bounds);
  const ConstraintTerm cone =
      make_constraint("cone", residual, ConstraintKind::second_order_cone, 1.0);
  const double infinity = std::numeric_limits<double>::infinity();
  const double lower[] = {-1, 0, 0}, upper[] = {1, 0, infinity};
  const double values[] = {1.0, 0.0, 0.5};
  EXPECT_EQ(distance_to_set(box, values, lower, upper), 0);
  const double right[] = {2, -3, 0}, wrong_side[] = {-2, 0, 0}, no_bound[] = {0, 0, 4};
  EXPECT_EQ(complementarity(box, values, lower, upper, right), 0);
  EXPECT_EQ(complementarity(box, values, lower, upper, wrong_side), 4);
  EXPECT_EQ(complementarity(box, values, lower, upper, no_bound), 4);
  const double short_of[] = {1.0, -0.5, 0.5}, pulls[] = {0, 7, 0};  // an equality has no interior
  EXPECT_EQ(complementarity(box, short_of, lower, upper, pulls), 0);
  const double off[] = {1.5, -0.1, -2};
  EXPECT_EQ(distance_to_set(box, off, lower, upper), 2);

  const double on_cone[] = {3, 4, 5}, normal[] = {0.6, 0.8, -1};
  EXPECT_NEAR(distance_to_set(cone, on_cone, nullptr, nullptr), 0, 1e-15);
  EXPECT_NEAR(complementarity(cone, on_cone, nullptr, nullptr, normal), 0, 1e-14);
  EXPECT_NEAR(complementarity(cone, on_cone, nullptr, nullptr, on_cone), 50, 1e-12);
  // Orthogonal to the value (any vector at the tip), but multipliers must lie in the polar cone.
  const double across[] = {-0.8, 0.6, 0}, inward[] = {0.6, 0.8, 1}, tip[] = {0, 0, 0};
  EXPECT_NEAR(complementarity(cone, on_cone, nullptr, nullptr, across), std::sqrt(0.5), 1e-14);
  EXPECT_NEAR(complementarity(cone, tip, nullptr, nullptr, inward), std::sqrt(2.0), 1e-14);
  const double outside[] = {3, 4, 0}, below[] = {0, 3, -4};
  EXPECT_NEAR(distance_to_set(cone, outside, nullptr, nullptr), 5 * std::sqrt(0.5), 1e-14);
  EXPECT_NEAR(distance_to_set(cone, below, nullptr, nullptr), 5, 1e-14);
}

TEST(ConstraintSet, SoftConesLimitMultipliersToThePolarCone) {
  const ConstraintTerm cone = make_constraint("cone", control_residual(0, 3),
                                              ConstraintKind::second_order_cone, 1.0, Softness::l1);
  const auto off = [&](std::vector<double> g, std::vector<double> nu) {
    const NodeConstraint c{
        .node = 0, .term = &cone, .row = 0, .lower = nullptr, .upper = nullptr, .limit = 2};
    return complementarity(c, g.data(), nu.data());
  };
  // On the cone, with a multiplier along its normal: within the limit and beyond it.
  EXPECT_NEAR(off({3, 4, 5}, {0.6, 0.8, -1}), 0, 1e-14);
  EXPECT_NEAR(off({3, 4, 5}, {3, 4, -5}), std::sqrt(50) - 2, 1e-14);
  // Outside, with the multiplier at the limit and at half the limit.
  const double h = std::sqrt(0.5);
  EXPECT_NEAR(off({3, 4, 0}, {0.6 * 2 * h, 0.8 * 2 * h, -2 * h}), 0, 1e-14);
  EXPECT_NEAR(off({3, 4, 0}, {0.6 * h, 0.8 * h, -h}), 5 * h, 1e-14);
  // Orthogonal to the value (any vector at the tip).
  EXPECT_NEAR(off({3, 4, 5}, {-0.8, 0.6, 0}), h, 1e-14);
  EXPECT_NEAR(off({0, 0, 0}, {0.6, 0.8, 1}), std::sqrt(2.0), 1e-14);
}

TEST(ConstraintSet, NaNIsNotInsideTheSet) {
  const ConstraintTerm box = make_constraint("box", control_residual(0, 1), ConstraintKind::bounds);
  const double nan = std::numeric_limits<double>::quiet_NaN(), zero = 0;
  EXPECT_TRUE(std::isnan(distance_to_set(box, &nan, &zero, &zero)));
  const ConstraintTerm three = make_constraint("c", control_residual(0, 3), ConstraintKind::bounds);
  const double zeros[] = {0, 0, 0};
  for (int i = 0; i < 3; ++i) {
    double values[] = {1, 2, 3};
    values[i] = nan;
    EXPECT_TRUE(std::isnan(distance_to_set(three, values, zeros, zeros))) << i;
  }
}

TEST(ConstraintSet, ConeNeedsTwoRowsAndASlope) {
  EXPECT_THROW(make_constraint("c", control_residual(0, 1), ConstraintKind::second_order_cone),
               std::invalid_argument);
  EXPECT_THROW(make_constraint("c", control_residual(0, 3), ConstraintKind::second_order_cone, 0),
               std::invalid_argument);
}

/// One constraint of each kind on state and control; some rows are active at a random point.
void add_constraints(KnotModel& model) {
  const auto state = state_residual(model.manifold());
  model.add_constraint(make_constraint("box", state, ConstraintKind::bounds));
  model.add_constraint(make_constraint("norm", state, ConstraintKind::norm));
  model.add_constraint(make_constraint("cone", state, ConstraintKind::second_order_cone, 0.7));
  if (model.nu() == 0) return;
  const auto control = control_residual(model.ndx(), model.nu());
  model.add_constraint(make_constraint("equality", control, ConstraintKind::bounds));
  if (model.nu() < 2) return;
  model.add_constraint(make_constraint("thrust", control, ConstraintKind::second_order_cone));
}

void set_bounds(KnotCase& c, RandomNumbers& random) {
  for (const ConstraintTerm& term : c.model->constraints()) {
    const int n = term.residual->parameter_count();
    double* p = &c.parameters[term.parameters];
    for (int i = 0; i < n; ++i) p[i] = random.uniform(-1, 1);
    if (n == c.model->nx()) {
      const auto reference = random_manifold_state(c.model->manifold(), random, 1.2);
      std::copy(reference.begin(), reference.end(), p);
    }
    for (int i = 0; term.has_bounds() && i < term.rows; ++i) {
      const double middle = random.uniform(-1, 1);
      const double width = term.name == "equality" ? 0 : random.uniform(0, 1);
      c.parameters[term.lower() + i] = middle - width;
      c.parameters[term.upper() + i] =
          i % 3 == 2 ? std::numeric_limits<double>::infinity() : middle + width;
    }
    c.parameters[term.active()] = 1;
  }
}

std::vector<KnotCase> constrained_cases() {
  std::vector<KnotCase> cases;
  RandomNumbers random(12);
  for (const auto& [name, system] : test_systems())
    for (const bool costs : {false, true}) {
      auto model = std::make_shared<KnotModel>(system, integrators_of(*system).front());
      if (costs) model->add_cost("state", state_residual(model->manifold()), {});
      add_constraints(*model);
      cases.push_back(make_case(name, model, random));
      set_bounds(cases.back(), random);
    }
  return cases;
}

Augmentation random_augmentation(const ShootingProblem& problem) {
  RandomNumbers random(17);
  Augmentation a(problem);
  for (const NodeConstraint& c : problem.constraints()) {
    const double penalty = random.uniform(0.5, 3);
    for (int i = 0; i < c.term->rows; ++i) {
      a.penalty[c.row + i] = penalty;
      a.shift[c.row + i] = random.uniform(-0.5, 0.5);
      a.multiplier[c.row + i] = random.uniform(-1, 1);
    }
  }
  return a;
}

Trajectory trajectory_of(const KnotCase& c, const ShootingProblem& problem) {
  Trajectory t = problem.create_trajectory();
  for (int k = 0; k < problem.knots(); ++k)
    for (int i = 0; i < c.model->nu(); ++i) t.u(k)[i] = c.u[i];
  return t;
}

/// Directional derivatives of constraint values and augmented cost, by dual numbers.
struct Slope {
  Eigen::VectorXd constraint;
  double cost;
};
Slope slope_along(const KnotCase& c, const Augmentation& augmentation, int direction) {
  using D = Dual<Lane>;
  const KnotModel& m = *c.model;
  KnotBatch<D> batch(m);
  for (int i = 0; i < m.nx(); ++i) batch.x[i] = D(c.x[i]);
  for (int i = 0; i < m.nu(); ++i) batch.u[i] = D(c.u[i]);
  for (int i = 0; i < m.parameter_count(); ++i) batch.parameters[i] = D(c.parameters[i]);
  for (int i = 0; i < m.constraint_rows(); ++i) {
    batch.penalty[i] = D(augmentation.penalty[i]);
    batch.shift[i] = D(augmentation.shift[i]);
    batch.multiplier[i] = D(augmentation.multiplier[i]);
  }
  batch.augmented = true;
  batch.dt = batch.cost_scale = D(c.dt);
  if (direction < m.ndx()) {
    batch.tangent[direction].d = Lane(1.0);
    m.manifold().integrate(batch.x.data(), batch.tangent.data(), batch.x.data());
  } else {
    batch.u[direction - m.ndx()].d = Lane(1.0);
  }
  m.evaluate(batch.input(), batch.work);
  Slope slope{Eigen::VectorXd(m.constraint_rows()),
              batch.work.cost.d[0] + batch.work.augmentation.d[0]};
  for (int i = 0; i < m.constraint_rows(); ++i) slope.constraint[i] = batch.work.constraint[i].d[0];
  return slope;
}

TEST(Constraints, DerivativesMatchDualNumbers) {
  for (const KnotCase& c : constrained_cases()) {
    const ShootingProblem problem = problem_of(c, 1);
    const Augmentation augmentation = random_augmentation(problem);
    Evaluator evaluator(problem);
    Linearization lin(problem);
    evaluator.differentiate(trajectory_of(c, problem), lin, &augmentation);
    for (int d = 0; d < c.model->nz(); d += kDirectionStride) {
      const Slope expected = slope_along(c, augmentation, d);
      EXPECT_NEAR(lin.knots[0].gradient[d], expected.cost, 1e-10 * (1 + std::abs(expected.cost)))
          << c.name << " direction " << d;
      EXPECT_LT((lin.knots[0].C.col(d) - expected.constraint).cwiseAbs().maxCoeff(),
                1e-10 * (1 + expected.constraint.cwiseAbs().maxCoeff()))
          << c.name << " direction " << d;
    }
  }
}

TEST(Constraints, LanesMatchDoubleAndTheDefinition) {
  for (const KnotCase& c : constrained_cases()) {
    const ShootingProblem problem = problem_of(c, kLaneWidth + 3);
    const Augmentation augmentation = random_augmentation(problem);
    RandomNumbers random(9);
    Trajectory t = trajectory_of(c, problem);
    for (int k = 0; k < problem.knots(); ++k) {
      const auto x = random_manifold_state(problem.manifold(), random, 1.0);
      for (int i = 0; i < problem.nx(); ++i) t.x(k)[i] = x[i];
    }
    Evaluator evaluator(problem);
    Evaluation lanes(problem);
    Linearization lin(problem);
    evaluator.evaluate(t, lanes, &augmentation);
    evaluator.differentiate(t, lin, &augmentation);
    KnotWorkspace<double> work(*c.model);
    Eigen::VectorXd expected = Eigen::VectorXd::Zero(problem.knots() + 1);
    for (const NodeConstraint& n : problem.constraints()) {
      c.model->evaluate(KnotInput<double>{t.x(n.node).data(), t.u(n.node).data(),
                                          c.parameters.data(), c.dt, c.dt},
                        work);
      Eigen::VectorXd shifted(n.term->rows);
      for (int i = 0; i < n.term->rows; ++i) {
        const double g = work.constraint[n.term->row + i];
        EXPECT_NEAR(lanes.constraint[n.row + i], g, 1e-12 * (1 + std::abs(g))) << c.name;
        EXPECT_EQ(lanes.constraint[n.row + i], lin.constraint[n.row + i]) << c.name;
        shifted[i] = g + augmentation.shift[n.row + i];
        expected[n.node] += augmentation.multiplier[n.row + i] * g;
      }
      double square = 0;
      if (n.term->has_bounds()) {
        for (int i = 0; i < n.term->rows; ++i)
          square += std::pow(outside_bounds(shifted[i], n.lower[i], n.upper[i]), 2);
      } else {
        square = std::pow(distance_to_set(*n.term, shifted.data(), nullptr, nullptr), 2);
      }
      expected[n.node] += 0.5 * augmentation.penalty[n.row] * square;
    }
    EXPECT_LT((lanes.augmentation - expected).cwiseAbs().maxCoeff(),
              1e-10 * (1 + expected.cwiseAbs().maxCoeff()))
        << c.name;
    EXPECT_LT((lin.augmentation - lanes.augmentation).cwiseAbs().maxCoeff(), 1e-10) << c.name;
  }
}

TEST(Constraints, GaussNewtonHessiansOfLinearConstraintsAreExact) {
  RandomNumbers random(14);
  const auto system = double_integrator(3);
  auto model = std::make_shared<KnotModel>(system, Integrator::explicit_euler);
  const auto control = control_residual(model->ndx(), model->nu());
  const auto state = state_residual(model->manifold());
  model->add_constraint(make_constraint("box", state, ConstraintKind::bounds));
  model->add_constraint(make_constraint("x", state, ConstraintKind::second_order_cone, 0.6));
  model->add_constraint(make_constraint("u", control, ConstraintKind::second_order_cone));
  for (int trial = 0; trial < 10; ++trial) {
    KnotCase c = make_case("linear", model, random);
    set_bounds(c, random);
    const ShootingProblem problem = problem_of(c, 1);
    const Augmentation augmentation = random_augmentation(problem);
    const Trajectory t = trajectory_of(c, problem);
    Evaluator evaluator(problem);
    Linearization lin(problem);
    evaluator.differentiate(t, lin, &augmentation);
    const Eigen::MatrixXd gauss_newton = lin.knots[0].hessian();
    evaluator.lagrangian_hessian(t, Eigen::MatrixXd::Zero(problem.ndx(), 2), lin, &augmentation);
    EXPECT_GT(gauss_newton.norm(), 0);
    EXPECT_LT((gauss_newton - lin.knots[0].hessian()).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(Constraints, GaussNewtonHessiansHaveNoNegativeCurvature) {
  for (const KnotCase& c : constrained_cases()) {
    const ShootingProblem problem = problem_of(c, 1);
    Augmentation augmentation = random_augmentation(problem);
    augmentation.multiplier.setZero();
    Evaluator evaluator(problem);
    Linearization lin(problem);
    evaluator.differentiate(trajectory_of(c, problem), lin, &augmentation);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(lin.knots[0].hessian());
    EXPECT_GT(eigen.eigenvalues()[0], -1e-10 * (1 + eigen.eigenvalues().maxCoeff())) << c.name;
  }
}

TEST(Constraints, AugmentedResultsIgnoreTheThreadCount) {
  for (const KnotCase& c : constrained_cases()) {
    const ShootingProblem problem = problem_of(c, 3 * kLaneWidth + 1);
    const Augmentation augmentation = random_augmentation(problem);
    const Trajectory t = trajectory_of(c, problem);
    Evaluator one(problem, 1), two(problem, 2);
    Linearization a(problem), b(problem);
    one.differentiate(t, a, &augmentation);
    two.differentiate(t, b, &augmentation);
    EXPECT_EQ(a.augmentation, b.augmentation) << c.name;
    for (std::size_t k = 0; k < a.knots.size(); ++k) {
      EXPECT_EQ(a.knots[k].hessian(), b.knots[k].hessian()) << c.name;
      EXPECT_EQ(a.knots[k].C, b.knots[k].C) << c.name;
    }
  }
}

TEST(Constraints, SwitchDisablesThemAndRolloutsCountTheRest) {
  RandomNumbers random(15);
  auto model = std::make_shared<KnotModel>(double_integrator(2), Integrator::rk4);
  add_constraints(*model);
  KnotCase c = make_case("double_integrator", model, random);
  set_bounds(c, random);
  const std::size_t all = problem_of(c, 1).constraints().size();
  c.parameters[model->constraints()[1].active()] = 0;
  const ShootingProblem problem = problem_of(c, 4);
  EXPECT_EQ(problem.constraints().size(), 4 * (all - 1));
  EXPECT_EQ(problem.constraint_rows(), 4 * model->constraint_rows());
  for (const NodeConstraint& n : problem.constraints()) EXPECT_NE(n.term->name, "norm");

  const Augmentation augmentation = random_augmentation(problem);
  Evaluator evaluator(problem);
  Trajectory t = trajectory_of(c, problem);
  ASSERT_EQ(evaluator.simulate(t), -1);
  Evaluation evaluation(problem);
  evaluator.evaluate(t, evaluation, &augmentation);
  LaneRollout rollout(problem);
  const double steps[kLaneWidth] = {};
  evaluator.roll_out(t, evaluation.gap, Feedback(problem), steps, {.augmentation = &augmentation},
                     rollout);
  const double expected = evaluation.cost.sum() + evaluation.augmentation.sum();
  EXPECT_NEAR(rollout.cost[0], expected, 1e-12 * (1 + std::abs(expected)));
  EXPECT_NE(evaluation.augmentation.sum(), 0);
}

/// Cost, gradient, and Hessian of one quadratic soft constraint with weight 3 on a state of two
/// entries, at cost scale 0.1.
struct SquareCost {
  SquareCost(ConstraintKind kind, std::vector<double> numbers, const std::vector<double>& x) {
    KnotModel model(double_integrator(1), Integrator::none);
    model.add_constraint(
        make_constraint("soft", state_residual(model.manifold()), kind, 1, Softness::l2));
    KnotWorkspace<double> work(model);
    const KnotInput<double> in{x.data(), nullptr, numbers.data(), 0, 0.1};
    model.evaluate(in, work);
    evaluated = work.cost;
    model.differentiate(in, work, true);
    cost = work.cost;
    gradient = Eigen::Map<const Eigen::Vector2d>(work.gradient.data());
    for (std::size_t e = 0; e < model.hessian_pattern().size(); ++e) {
      const auto& [row, column] = model.hessian_pattern()[e];
      hessian(row, column) = hessian(column, row) = work.hessian[e];
    }
    EXPECT_EQ(work.augmentation, 0);
  }

  void expect(double value, const Eigen::Vector2d& slope, const Eigen::Matrix2d& curvature) const {
    EXPECT_NEAR(evaluated, value, 1e-15);
    EXPECT_NEAR(cost, value, 1e-15);
    EXPECT_LT((gradient - slope).norm(), 1e-15);
    EXPECT_LT((hessian - curvature).norm(), 1e-15);
  }

  double evaluated, cost;
  Eigen::Vector2d gradient;
  Eigen::Matrix2d hessian = Eigen::Matrix2d::Zero();
};

// References, lower and upper bounds, switch, and weight.
TEST(SoftBySquare, RowsCostHalfWeightedSquaredDistance) {
  const auto of = [](double active, const std::vector<double>& x) {
    return SquareCost(ConstraintKind::bounds, {0.5, 0, -1, -2, 1, 0.5, active, 3}, x);
  };
  // Both rows are outside: 2.5 − 0.5 is 1 above, −2.25 is 0.25 below.
  of(1, {2.5, -2.25})
      .expect(0.5 * 0.3 * (1 + 0.0625), {0.3, 0.3 * -0.25}, 0.3 * Eigen::Matrix2d::Identity());
  of(1, {2.5, 0}).expect(0.5 * 0.3, {0.3, 0}, Eigen::Vector2d(0.3, 0).asDiagonal());
  of(1, {0.5, 0}).expect(0, {0, 0}, Eigen::Matrix2d::Zero());
  of(0, {2.5, -2.25}).expect(0, {0, 0}, Eigen::Matrix2d::Zero());
}

// Consecutive terms of different sizes: each has its own weight and no shift.
TEST(SoftBySquare, TermsOfAKnotAreIndependent) {
  KnotModel model(double_integrator(2), Integrator::none);
  std::vector<double> numbers;
  const auto add = [&](const std::shared_ptr<const Residual>& residual, double weight) {
    model.add_constraint(
        make_constraint("soft", residual, ConstraintKind::bounds, 1, Softness::l2));
    const int rows = residual->size();
    numbers.resize(numbers.size() + residual->parameter_count() + rows,
                   -std::numeric_limits<double>::infinity());
    std::fill(numbers.end() - rows - residual->parameter_count(), numbers.end() - rows, 0.0);
    numbers.resize(numbers.size() + rows, 1.0);
    numbers.insert(numbers.end(), {1, weight});
  };
  add(state_residual(model.manifold()), 2);
  const std::vector<KnotName> names = {{"first", "", {{false, 0}}, {}},
                                       {"fourth", "", {{false, 3}}, {}}};
  add(make_expression_residual(model.manifold(), {.names = names, .rows = {"first", "fourth"}})
          .residual,
      3);
  add(state_residual(model.manifold()), 2);
  KnotWorkspace<double> work(model);
  const std::vector<double> x = {2, 3, -1, 1.5};
  model.evaluate(KnotInput<double>{x.data(), nullptr, numbers.data(), 0, 1}, work);
  EXPECT_NEAR(work.cost, 2 * 0.5 * 2 * (1 + 4 + 0.25) + 0.5 * 3 * (1 + 0.25), 1e-14);
}

// ‖3‖ ≤ 1: the nearest point of the cone is (2, 2).
TEST(SoftBySquare, ConesCostHalfWeightedSquaredDistance) {
  const SquareCost outside(ConstraintKind::second_order_cone, {0, 0, 1, 3}, {3, 1});
  outside.expect(0.5 * 0.3 * 2, {0.3, -0.3}, Eigen::Matrix2d{{0.15, -0.15}, {-0.15, 0.15}});
  const SquareCost inside(ConstraintKind::second_order_cone, {0, 0, 1, 3}, {1, 3});
  inside.expect(0, {0, 0}, Eigen::Matrix2d::Zero());
}

}  // namespace
}  // namespace conddp
