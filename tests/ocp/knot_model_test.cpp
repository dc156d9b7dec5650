#include "ocp/knot/knot_model.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "ocp/evaluation/evaluator.hpp"
#include "support/knot_case.hpp"
#include "support/sizes.hpp"

namespace conddp {
namespace {

Trajectory random_trajectory(const ShootingProblem& problem, std::uint64_t seed) {
  RandomNumbers random(seed);
  Trajectory t = problem.create_trajectory();
  for (int k = 0; k <= problem.knots(); ++k) {
    const auto x = random_manifold_state(problem.manifold(), random, 1.0);
    for (int i = 0; i < problem.nx(); ++i) t.x(k)[i] = x[i];
    if (k == problem.knots()) break;
    for (int i = 0; i < problem.nu(k); ++i) t.u(k)[i] = random.uniform(-2, 2);
  }
  return t;
}

void add_state_and_control_costs(KnotModel& model) {
  model.add_cost("state", state_residual(model.manifold()), {});
  model.add_cost("norm", state_residual(model.manifold()),
                 {.kind = ActivationKind::smooth_l2, .epsilon = 0.3});
  if (model.nu() == 0) return;
  model.add_cost("control", control_residual(model.step().control_column(0), model.nu()),
                 {.kind = ActivationKind::smooth_l1, .epsilon = 0.5});
}

std::vector<KnotCase> all_cases() {
  std::vector<KnotCase> cases;
  RandomNumbers random(11);
  for (const auto& [name, system] : test_systems())
    for (const Integrator integrator : integrators_of(*system))
      for (const Memory memory : {Memory::none, Memory::previous, Memory::linear}) {
        if (memory != Memory::none && integrator == Integrator::impulse) continue;
        if (memory == Memory::linear && !follows_controls(integrator)) continue;
        auto model = std::make_shared<KnotModel>(step_with(system, integrator, memory));
        add_state_and_control_costs(*model);
        if (memory == Memory::previous) model->add_cost("rate", control_rate_residual(*system), {});
        constexpr const char* kNames[] = {"", "/previous", "/linear"};
        cases.push_back(make_case(name + "/" + std::to_string(static_cast<int>(integrator)) +
                                      kNames[static_cast<int>(memory)],
                                  model, random));
      }
  return cases;
}

TEST(KnotModel, DerivativesMatchDualNumbersThroughTheStep) {
  for (const KnotCase& c : all_cases()) {
    const ShootingProblem problem = problem_of(c, 1);
    Evaluator evaluator(problem);
    Linearization lin(problem);
    Trajectory t = problem.create_trajectory();
    for (int i = 0; i < c.model->nu(); ++i) t.u(0)[i] = c.u[i];
    evaluator.differentiate(t, lin);
    const Eigen::MatrixXd jacobian = lin.knots[0].dense_jacobian();
    for (int d = 0; d < c.model->nz(); d += kDirectionStride) {
      const DirectionalDerivative expected = directional_derivative(c, d);
      const double scale = 1 + expected.next.cwiseAbs().maxCoeff();
      EXPECT_LT((jacobian.col(d) - expected.next).cwiseAbs().maxCoeff(), 1e-10 * scale)
          << c.name << " direction " << d;
      EXPECT_NEAR(lin.knots[0].gradient[d], expected.cost, 1e-10 * (1 + std::abs(expected.cost)))
          << c.name << " direction " << d;
    }
  }
}

TEST(KnotModel, TransposedProductsAgreeWithTheDenseJacobian) {
  for (const KnotCase& c : all_cases()) {
    const ShootingProblem problem = problem_of(c, 1);
    Evaluator evaluator(problem);
    Linearization lin(problem);
    evaluator.differentiate(problem.create_trajectory(), lin);
    const Eigen::MatrixXd jacobian = lin.knots[0].dense_jacobian();
    RandomNumbers random(5);
    Eigen::VectorXd lambda(c.model->ndx()), out(c.model->nz()), scratch(c.model->ndx());
    for (double& l : lambda) l = random.uniform(-1, 1);
    lin.knots[0].apply_transpose(lambda, out, scratch);
    EXPECT_LT((out - jacobian.transpose() * lambda).cwiseAbs().maxCoeff(), 1e-10) << c.name;
  }
}

TEST(Evaluator, LanesMatchDoubleInRaggedGroups) {
  for (const KnotCase& c : all_cases()) {
    const ShootingProblem problem = problem_of(c, kLaneWidth + 3);
    const Trajectory t = random_trajectory(problem, 21);
    Evaluator evaluator(problem);
    Evaluation lanes(problem);
    evaluator.evaluate(t, lanes);
    Linearization lin(problem);
    evaluator.differentiate(t, lin);
    KnotWorkspace<double> work(*c.model);
    Eigen::VectorXd gap(problem.ndx());
    for (int k = 0; k < problem.knots(); ++k) {
      const KnotInput<double> in{t.x(k).data(), t.u(k).data(), c.parameters.data(), c.dt, c.dt};
      c.model->differentiate(in, work, true);
      EXPECT_NEAR(lanes.cost[k], work.cost, 1e-12 * (1 + work.cost)) << c.name;
      EXPECT_NEAR(lin.cost[k], work.cost, 1e-12 * (1 + work.cost)) << c.name;
      problem.manifold().difference(t.x(k + 1).data(), work.next().data(), gap.data());
      const double scale = 1 + gap.cwiseAbs().maxCoeff();
      EXPECT_LT((lanes.gap.col(k) - gap).cwiseAbs().maxCoeff(), 1e-9 * scale) << c.name;
      EXPECT_LT((lin.gap.col(k) - gap).cwiseAbs().maxCoeff(), 1e-9 * scale) << c.name;
      const Eigen::Map<const Eigen::MatrixXd> F(work.F().data(), lin.knots[k].F.rows(),
                                                lin.knots[k].F.cols());
      EXPECT_LT((lin.knots[k].F - F).cwiseAbs().maxCoeff(), 1e-10 * (1 + F.cwiseAbs().maxCoeff()))
          << c.name;
    }
  }
}

TEST(Evaluator, ResultsIgnoreTheThreadCount) {
  for (const KnotCase& c : all_cases()) {
    const ShootingProblem problem = problem_of(c, 3 * kLaneWidth + 1);
    const Trajectory t = random_trajectory(problem, 22);
    Evaluator one(problem, 1), two(problem, 2);
    Linearization a(problem), b(problem);
    one.differentiate(t, a);
    two.differentiate(t, b);
    EXPECT_EQ(a.cost, b.cost) << c.name;
    EXPECT_EQ(a.gap, b.gap) << c.name;
    for (std::size_t k = 0; k < a.knots.size(); ++k) {
      EXPECT_EQ(a.knots[k].hessian(), b.knots[k].hessian()) << c.name;
      EXPECT_EQ(a.knots[k].F, b.knots[k].F) << c.name;
    }
  }
}

TEST(KnotModel, BarriersFollowOtherCostsInThePattern) {
  const auto system = test_systems().front().second;
  const auto add_cost = [](KnotModel& model) {
    model.add_cost("state", state_residual(model.manifold()), {});
  };
  const auto add_barrier = [](KnotModel& model) {
    model.add_cost("effort", control_residual(model.ndx(), model.nu()),
                   {.kind = ActivationKind::quadratic_barrier,
                    .lower = std::vector<double>(model.nu(), -100),
                    .upper = std::vector<double>(model.nu(), 100)});
  };
  KnotModel barrier_last(system, integrators_of(*system).front()), barrier_first = barrier_last;
  add_cost(barrier_last);
  add_barrier(barrier_last);
  add_barrier(barrier_first);
  add_cost(barrier_first);
  EXPECT_GT(static_cast<int>(barrier_last.hessian_pattern().size()),
            barrier_last.lasting_entries());
  EXPECT_EQ(barrier_first.hessian_pattern(), barrier_last.hessian_pattern());
  EXPECT_EQ(barrier_first.lasting_entries(), barrier_last.lasting_entries());
}

TEST(Evaluator, ClearsThePreviousHessian) {
  bool barriers_rested = false, barriers_worked = false;
  RandomNumbers random(12);
  for (const auto& [name, system] : test_systems()) {
    if (system->nu() == 0) continue;
    auto model = std::make_shared<KnotModel>(system, integrators_of(*system).front());
    model->add_cost("state", state_residual(model->manifold()), {});
    model->add_cost("effort", control_residual(model->ndx(), model->nu()),
                    {.kind = ActivationKind::quadratic_barrier,
                     .lower = std::vector<double>(model->nu(), -100),
                     .upper = std::vector<double>(model->nu(), 100)});
    const KnotCase c = make_case(name, model, random);
    const ShootingProblem problem = problem_of(c, kLaneWidth + 1);
    Evaluator evaluator(problem, 1);
    Linearization used(problem);
    const Eigen::MatrixXd costates = Eigen::MatrixXd::Ones(problem.ndx(), problem.knots() + 1);
    for (const double effort : {1000, 1, 1000, 1}) {
      Trajectory t = random_trajectory(problem, 31);
      for (int k = 0; k < problem.knots(); ++k) t.u(k) *= effort;
      const auto expect_as_new = [&](const char* after) {
        Linearization fresh(problem);
        evaluator.differentiate(t, fresh);
        evaluator.differentiate(t, used);
        for (std::size_t k = 0; k < used.knots.size(); ++k) {
          const KnotHessian &now = used.knots[k].hessian, &expected = fresh.knots[k].hessian;
          EXPECT_EQ(now(), expected()) << name << " after " << after;
          EXPECT_EQ(now.fill(), expected.fill()) << name << " after " << after;
          barriers_rested |= now.fill() == HessianFill::lasting;
          barriers_worked |= now.fill() == HessianFill::pattern;
        }
      };
      expect_as_new("another iterate");
      evaluator.lagrangian_hessian(t, costates, used);
      EXPECT_EQ(used.knots[0].hessian.fill(), HessianFill::all);
      expect_as_new("an exact Hessian");
    }
  }
  EXPECT_TRUE(barriers_rested);
  EXPECT_TRUE(barriers_worked);
}

/// φ(δ) = cost + λᵀ (f(z ⊕ δ) ⊖ f(z)), differentiated along direction j at δ = step·e_i.
double lagrangian_slope(const KnotCase& c, const Eigen::VectorXd& lambda, int i, double step,
                        int j) {
  using D = Dual<Lane>;
  KnotBatch<D> batch(*c.model);
  const KnotModel& m = *c.model;
  const auto run = [&](double at, bool seed) {
    for (int k = 0; k < m.nx(); ++k) batch.x[k] = D(c.x[k]);
    for (int k = 0; k < m.nu(); ++k) batch.u[k] = D(c.u[k]);
    for (int k = 0; k < m.parameter_count(); ++k) batch.parameters[k] = D(c.parameters[k]);
    batch.dt = batch.cost_scale = D(c.dt);
    for (D& t : batch.tangent) t = D(0.0);
    const auto entry = [&](int index) -> D& {
      return index < m.ndx() ? batch.tangent[index] : batch.u[index - m.ndx()];
    };
    entry(i).v = entry(i).v + Lane(at);
    if (seed) entry(j).d = Lane(1.0);
    m.manifold().integrate(batch.x.data(), batch.tangent.data(), batch.x.data());
    m.evaluate(batch.input(), batch.work);
  };
  run(0, false);
  const AlignedVector<D> origin = batch.work.next();
  run(step, true);
  m.manifold().difference(origin.data(), batch.work.next().data(), batch.tangent.data());
  double slope = batch.work.cost.d[0];
  for (int k = 0; k < m.ndx(); ++k) slope += lambda[k] * batch.tangent[k].d[0];
  return slope;
}

TEST(Evaluator, LagrangianHessianMatchesManifoldSecondDerivative) {
  for (const KnotCase& c : all_cases()) {
    const ShootingProblem problem = problem_of(c, 1);
    Evaluator evaluator(problem);
    Linearization lin(problem);
    Trajectory t = problem.create_trajectory();
    for (int i = 0; i < c.model->nu(); ++i) t.u(0)[i] = c.u[i];
    evaluator.differentiate(t, lin);
    Eigen::MatrixXd costates = Eigen::MatrixXd::Zero(problem.ndx(), 2);
    RandomNumbers random(9);
    for (int i = 0; i < problem.ndx(); ++i) costates(i, 1) = random.uniform(-1, 1);
    evaluator.lagrangian_hessian(t, costates, lin);
    const Eigen::MatrixXd& h = lin.knots[0].hessian();
    const double scale = 1 + h.cwiseAbs().maxCoeff();
    const double step = 1e-4;
    for (int i = 0; i < c.model->nz(); i += kDirectionStride)
      for (int j = 0; j <= i; j += kDirectionStride) {
        const double expected = (lagrangian_slope(c, costates.col(1), i, step, j) -
                                 lagrangian_slope(c, costates.col(1), i, -step, j)) /
                                (2 * step);
        EXPECT_NEAR(h(i, j), expected, 2e-6 * scale) << c.name << " entry " << i << ' ' << j;
      }
  }
}

TEST(KnotModel, RungeKuttaRulesReachTheirOrderOnManifolds) {
  const auto robot = std::make_shared<RobotModel>(
      random_robot(4, {.joints = 2, .floating = true, .rotors = false, .wrenches = 0}));
  const auto system = std::make_shared<MultibodySystem>(robot, Actuation::full(*robot));
  RandomNumbers random(31);
  std::vector<double> x0 = random_manifold_state(system->manifold(), random, 1.0);
  const std::vector<double> u = random.numbers(system->nu(), 1.0);
  const auto final_state = [&](Integrator rule, int steps) {
    KnotModel model(system, rule);
    KnotWorkspace<double> work(model);
    std::vector<double> x = x0;
    const double dt = 0.2 / steps;
    for (int k = 0; k < steps; ++k) {
      model.evaluate(KnotInput<double>{x.data(), u.data(), nullptr, dt, dt}, work);
      x.assign(work.next().begin(), work.next().end());
    }
    return x;
  };
  const std::vector<double> exact = final_state(Integrator::rk4, 2000);
  const auto error = [&](Integrator rule, int steps) {
    const std::vector<double> x = final_state(rule, steps);
    Eigen::VectorXd d(system->ndx());
    system->manifold().difference(exact.data(), x.data(), d.data());
    return d.norm();
  };
  const std::pair<Integrator, double> rules[] = {{Integrator::semi_implicit_euler, 1},
                                                 {Integrator::explicit_euler, 1},
                                                 {Integrator::rk2, 2},
                                                 {Integrator::rk3, 3},
                                                 {Integrator::rk4, 4}};
  for (const auto& [rule, order] : rules) {
    const double observed = std::log2(error(rule, 20) / error(rule, 40));
    EXPECT_NEAR(observed, order, 0.25) << "rule " << static_cast<int>(rule);
  }
}

TEST(Evaluator, FullStepRolloutClosesContractedGaps) {
  RandomNumbers random(3);
  const auto system = quadrotor({});
  auto model = std::make_shared<KnotModel>(system, Integrator::semi_implicit_euler);
  add_state_and_control_costs(*model);
  const KnotCase c = make_case("quadrotor", model, random);
  const ShootingProblem problem = problem_of(c, 12);
  Trajectory t = random_trajectory(problem, 77);
  t.x(0) = Eigen::Map<const Eigen::VectorXd>(c.x.data(), problem.nx());
  Evaluator evaluator(problem);
  Evaluation before(problem), after(problem);
  evaluator.evaluate(t, before);
  Feedback none(problem);
  LaneRollout rollout(problem);
  double steps[kLaneWidth];
  for (int l = 0; l < kLaneWidth; ++l) steps[l] = std::pow(0.5, l);
  evaluator.roll_out(t, before.gap, none, steps, {.contract_gaps = true}, rollout);
  SingleRollout alone(problem);
  for (int l = 0; l < kLaneWidth; ++l) {
    Trajectory moved = problem.create_trajectory();
    rollout.extract(l, moved);
    evaluator.roll_out(t, before.gap, none, steps[l], {.contract_gaps = true}, alone);
    EXPECT_NEAR(alone.cost, rollout.cost[l], 1e-12 * std::abs(alone.cost));
    for (int k = 0; k <= problem.knots(); ++k)
      EXPECT_LT((alone.trajectory.x(k) - moved.x(k)).norm(), 1e-12 * moved.x(k).norm()) << k;
    evaluator.evaluate(moved, after);
    EXPECT_LT((after.gap - (1 - steps[l]) * before.gap).cwiseAbs().maxCoeff(), 1e-9) << steps[l];
    EXPECT_NEAR(after.cost.sum(), rollout.cost[l], 1e-10 * std::abs(rollout.cost[l]));
  }
}

TEST(Evaluator, DivergedLaneNamesItsKnotAndSparesOthers) {
  const auto system = linear_system(Eigen::MatrixXd::Constant(1, 1, 1e200),
                                    Eigen::MatrixXd::Identity(1, 1), Eigen::VectorXd::Zero(1));
  auto model = std::make_shared<KnotModel>(system, Integrator::discrete);
  const ShootingProblem problem = problem_of({"blow-up", model, {0.0}, {0.0}, {}, 1.0}, 5);
  Evaluator evaluator(problem);
  Feedback feedback(problem);
  feedback.k[0][0] = 1;
  LaneRollout rollout(problem);
  double steps[kLaneWidth] = {};
  steps[0] = 1;
  evaluator.roll_out(problem.create_trajectory(), Eigen::MatrixXd(), feedback, steps, {}, rollout);
  EXPECT_EQ(rollout.first_bad_knot[0], 2);
  for (int l = 1; l < kLaneWidth; ++l) EXPECT_EQ(rollout.first_bad_knot[l], -1);
  SingleRollout alone(problem);
  evaluator.roll_out(problem.create_trajectory(), Eigen::MatrixXd(), feedback, 1.0, {}, alone);
  EXPECT_EQ(alone.first_bad_knot, 2);
}

/// Includes linear controls, where the second half of a step continues from the end of the first.
TEST(KnotModel, ExplicitRulesHaveTheirOrderWithLinearControls) {
  for (const Integrator rule : {Integrator::rk3, Integrator::rk4}) {
    const KnotModel model(step_with(cartpole({}), rule, Memory::linear));
    KnotWorkspace<double> work(model);
    const auto end_after = [&](int steps) {
      std::vector<double> x = {0.1, 2, 0.3, -1, 3};  // and the control at the start
      const double h = 0.4 / steps;
      for (int k = 0; k < steps; ++k) {
        const double u = 3 - 20 * h * (k + 1);
        model.evaluate(KnotInput<double>{x.data(), &u, nullptr, h, 1.0}, work);
        x.assign(work.next().begin(), work.next().end());
      }
      EXPECT_NEAR(x[4], -5, 1e-12);
      return x;
    };
    const std::vector<double> exact = end_after(4000);
    const auto error = [&](int steps) {
      const std::vector<double> x = end_after(steps);
      double largest = 0;
      for (int i = 0; i < 4; ++i) largest = std::max(largest, std::abs(x[i] - exact[i]));
      return largest;
    };
    EXPECT_NEAR(std::log2(error(20) / error(40)), info_of(rule).order, 0.2);
  }
}

TEST(KnotModel, LinearControlsNeedStagesInAStep) {
  for (const Integrator rule : {Integrator::semi_implicit_euler, Integrator::explicit_euler})
    EXPECT_THROW(Step(pendulum({}), rule).make_controls_linear(), std::invalid_argument);
  EXPECT_NO_THROW(Step(pendulum({}), Integrator::none).make_controls_linear());
}

}  // namespace
}  // namespace conddp
