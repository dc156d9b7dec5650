// Collocation steps: order, derivatives, and typical uses.
#include <algorithm>
#include <cmath>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "ocp/knot/collocation_residual.hpp"
#include "support/random_robot.hpp"
#include "support/sizes.hpp"
#include "support/steps.hpp"
#include "systems/closed_forms/catalogue.hpp"
#include "systems/expressions/system.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {
namespace {

constexpr CollocationRule kRules[] = {CollocationRule::trapezoidal,
                                      CollocationRule::hermite_simpson, CollocationRule::radau3,
                                      CollocationRule::radau5};

const IntegratorInfo& info_of(CollocationRule rule) {
  for (const IntegratorInfo& info : kIntegrators)
    if (info.collocation == rule) return info;
  throw std::logic_error("no integrator of this rule");
}

/// Takes steps of one length with constant controls, or controls that grow by 0.2 per second.
class March {
 public:
  /// Uses an explicit rule.
  March(const std::shared_ptr<const System>& system, Integrator rule, Memory memory = Memory::none)
      : model_(step_with(system, rule, memory)), work_(model_), w_(model_.nu(), 0.0) {}
  March(const std::shared_ptr<const CollocationSystem>& system, Memory memory = Memory::none)
      : model_(with_constraint(system, memory)), work_(model_), w_(model_.nu(), 0.0) {}

  const KnotModel& model() const { return model_; }
  const KnotWorkspace<double>& work() const { return work_; }

  void differentiate(const std::vector<double>& x, const std::vector<double>& w, double h) {
    std::vector<double> parameters(model_.parameter_count(), 0.0);
    for (const ConstraintTerm& term : model_.constraints()) {
      parameters[term.parameters] = h;
      parameters[term.active()] = 1;
    }
    model_.differentiate(KnotInput<double>{x.data(), w.data(), parameters.data(), h, 1.0}, work_,
                         false);
  }

  /// ∂g/∂z of the last call.
  Eigen::MatrixXd constraint_jacobian() const {
    Eigen::MatrixXd C = Eigen::MatrixXd::Zero(model_.constraint_rows(), model_.nz());
    const auto& pattern = model_.constraint_pattern();
    for (std::size_t i = 0; i < pattern.size(); ++i)
      C(pattern[i].first, pattern[i].second) = work_.constraint_jacobian[i];
    return C;
  }

  /// State after `steps` steps of h. Newton's method solves for the slopes of each step.
  std::vector<double> go(std::vector<double> x, const std::vector<double>& u, double h, int steps) {
    const bool linear = model_.step().has_linear_controls();
    if (linear) x.insert(x.end(), u.begin(), u.end());
    const int m = static_cast<int>(u.size()), unknown = model_.nu() - m;
    for (int k = 0; k < steps; ++k) {
      for (int j = 0; j < m; ++j) w_[j] = u[j] + (linear ? 0.2 * (k + 1) * h : 0);
      differentiate(x, w_, h);
      for (int i = 0; unknown > 0 && i < 20; ++i) {
        const Eigen::Map<const Eigen::VectorXd> g(work_.constraint.data(), unknown);
        const Eigen::VectorXd change =
            constraint_jacobian().rightCols(unknown).partialPivLu().solve(g);
        for (int j = 0; j < unknown; ++j) w_[m + j] -= change[j];
        differentiate(x, w_, h);
        if (change.lpNorm<Eigen::Infinity>() < 1e-13) break;
      }
      x.assign(work_.next().begin(), work_.next().end());
    }
    return x;
  }

 private:
  static KnotModel with_constraint(const std::shared_ptr<const CollocationSystem>& system,
                                   Memory memory) {
    KnotModel model(step_with(system, info_of(system->rule()).integrator, memory));
    model.add_constraint(make_constraint(
        "collocation",
        collocation_residual(system, model.ndx(), std::nullopt, model.step().has_linear_controls()),
        ConstraintKind::bounds));
    return model;
  }

  KnotModel model_;
  KnotWorkspace<double> work_;
  std::vector<double> w_;
};

struct Course {
  std::string name;
  std::shared_ptr<const System> system;
  std::vector<double> x, u;
};

std::vector<Course> motions() {
  const auto robot = std::make_shared<RobotModel>(random_robot(7, {.joints = 3}));
  const auto arm =
      std::make_shared<MultibodySystem>(robot, Actuation::joints(*robot, {robot->joints[1].name}));
  return {{"pendulum", pendulum({}), {0.5, -1}, {0.8}},
          {"cartpole", cartpole({}), {0.1, 2, 0.3, -1}, {2}},
          {"unicycle", unicycle(), {0, 0, 0.2}, {1, 1.5}},
          {"robot", arm, {0.3, -0.4, 0.5, 0.2, -0.1, 0.4}, {1}}};
}

class CollocationOfARule : public ::testing::TestWithParam<CollocationRule> {
 protected:
  void expect_order(Memory memory) const;
  void expect_derivatives(Memory memory) const;
};

void CollocationOfARule::expect_order(Memory memory) const {
  const int order = info_of(GetParam()).order;
  for (const Course& motion : motions()) {
    SCOPED_TRACE(motion.name);
    constexpr double kTime = 1;
    constexpr int kFine = 4000;
    const std::vector<double> exact =
        March(motion.system, Integrator::rk4, memory).go(motion.x, motion.u, kTime / kFine, kFine);
    March march(std::make_shared<CollocationSystem>(motion.system, GetParam()), memory);
    double error[2];
    for (const int half : {0, 1}) {
      // With growing controls, order 5 shows only for shorter steps.
      const int least = order <= 4 ? 40 : memory == Memory::linear ? 30 : 20;
      const int steps = half == 0 ? least : 2 * least;
      const std::vector<double> end = march.go(motion.x, motion.u, kTime / steps, steps);
      error[half] = 0;
      for (std::size_t i = 0; i < end.size(); ++i)
        error[half] = std::max(error[half], std::abs(end[i] - exact[i]));
    }
    EXPECT_NEAR(std::log2(error[0] / error[1]), order, 0.2) << error[0] << ", " << error[1];
    EXPECT_GT(error[1], 1e-13);
  }
}

TEST_P(CollocationOfARule, HasItsOrder) { expect_order(Memory::none); }

TEST_P(CollocationOfARule, HasItsOrderWithLinearControls) { expect_order(Memory::linear); }

void CollocationOfARule::expect_derivatives(Memory memory) const {
  constexpr double kStep = 0.07, kDifference = 1e-6;
  for (Course motion : motions()) {
    SCOPED_TRACE(motion.name);
    March march(std::make_shared<CollocationSystem>(motion.system, GetParam()), memory);
    const KnotModel& model = march.model();
    std::vector<double> w = motion.u;
    while (static_cast<int>(motion.x.size()) < model.nx()) motion.x.push_back(-0.7);
    RandomNumbers random(3);
    while (static_cast<int>(w.size()) < model.nu()) w.push_back(random.uniform(-2, 2));
    march.differentiate(motion.x, w, kStep);
    const Eigen::MatrixXd C = march.constraint_jacobian();
    const Eigen::MatrixXd F =
        Eigen::Map<const Eigen::MatrixXd>(march.work().F().data(), model.ndx(), model.nz());
    for (int c = 0; c < model.nz(); c += kDirectionStride) {
      Eigen::VectorXd next[2], value[2];
      for (const int side : {0, 1}) {
        std::vector<double> x = motion.x, v = w;
        (c < model.ndx() ? x[c] : v[c - model.ndx()]) += side == 0 ? -kDifference : kDifference;
        march.differentiate(x, v, kStep);
        next[side] = Eigen::Map<const Eigen::VectorXd>(march.work().next().data(), model.nx());
        value[side] = Eigen::Map<const Eigen::VectorXd>(march.work().constraint.data(), C.rows());
      }
      const auto off = [&](const Eigen::VectorXd* both, const Eigen::MatrixXd& by) {
        return ((both[1] - both[0]) / (2 * kDifference) - by.col(c)).lpNorm<Eigen::Infinity>();
      };
      EXPECT_LE(off(next, F), 1e-8) << c;
      EXPECT_LE(off(value, C), 1e-6) << c;
    }
  }
}

TEST_P(CollocationOfARule, DerivativesMatchDifferences) { expect_derivatives(Memory::none); }

TEST_P(CollocationOfARule, DerivativesMatchDifferencesWithLinearControls) {
  expect_derivatives(Memory::linear);
}

INSTANTIATE_TEST_SUITE_P(Rules, CollocationOfARule, ::testing::ValuesIn(kRules),
                         [](const auto& rule) { return std::string(info_of(rule.param).name); });

// A step of h in a phase that lasts 1.5 times its nominal duration is a step of 1.5 h.
TEST(Collocation, FreeDurationMatchesLongerStepAndItsSlope) {
  constexpr double kStep = 0.07, kDifference = 1e-6;
  for (const CollocationRule rule : kRules)
    for (const Memory memory : {Memory::none, Memory::linear}) {
      const auto system = std::make_shared<CollocationSystem>(cartpole({}), rule);
      const auto model_of = [&](int choices, const std::optional<FreeDuration>& duration) {
        auto model = std::make_shared<KnotModel>(
            step_with(system, info_of(rule).integrator, memory, choices));
        model->add_constraint(make_constraint(
            "collocation",
            collocation_residual(system, model->ndx(), duration, memory == Memory::linear),
            ConstraintKind::bounds));
        return model;
      };
      const auto plain = model_of(0, std::nullopt),
                 free = model_of(2, FreeDuration{.choice = 1, .written = 2});
      RandomNumbers random(4);
      const std::vector<double> w = random.numbers(plain->nu(), 2);
      std::vector<double> x = random.numbers(plain->nx(), 1), longer = x;
      longer.insert(longer.begin() + 4, {0.4, 3.0});
      const auto differentiated = [&](const KnotModel& model, const std::vector<double>& at,
                                      double h) {
        std::vector<double> parameters(model.parameter_count(), 0.0);
        parameters.front() = h;
        parameters.back() = 1;
        auto work = std::make_unique<KnotWorkspace<double>>(model);
        const KnotInput<double> in{at.data(), w.data(), parameters.data(), h, 1};
        model.evaluate(in, *work);
        const AlignedVector<double> evaluated = work->constraint;
        model.differentiate(in, *work, false);
        for (std::size_t i = 0; i < evaluated.size(); ++i)
          EXPECT_NEAR(evaluated[i], work->constraint[i], 1e-15) << i;
        return work;
      };
      const auto own = differentiated(*free, longer, kStep);
      const auto expected = differentiated(*plain, x, 1.5 * kStep);
      Eigen::MatrixXd C = Eigen::MatrixXd::Zero(free->constraint_rows(), free->nz()),
                      D = Eigen::MatrixXd::Zero(free->constraint_rows(), plain->nz());
      for (std::size_t e = 0; e < free->constraint_pattern().size(); ++e)
        C(free->constraint_pattern()[e].first, free->constraint_pattern()[e].second) =
            own->constraint_jacobian[e];
      for (std::size_t e = 0; e < plain->constraint_pattern().size(); ++e)
        D(plain->constraint_pattern()[e].first, plain->constraint_pattern()[e].second) =
            expected->constraint_jacobian[e];
      for (int row = 0; row < free->constraint_rows(); ++row)
        EXPECT_NEAR(own->constraint[row], expected->constraint[row], 1e-13) << row;
      EXPECT_LT((C.leftCols(4) - D.leftCols(4)).norm(), 1e-13);
      EXPECT_TRUE(C.col(4).isZero(0));
      EXPECT_LT((C.rightCols(free->nz() - 6) - D.rightCols(plain->nz() - 4)).norm(), 1e-13);
      longer[5] = 3 + kDifference;
      const auto after = differentiated(*free, longer, kStep);
      longer[5] = 3 - kDifference;
      const auto before = differentiated(*free, longer, kStep);
      for (int row = 0; row < free->constraint_rows(); ++row)
        EXPECT_NEAR(C(row, 5),
                    (after->constraint[row] - before->constraint[row]) / (2 * kDifference), 1e-7)
            << row;
    }
}

/// An overdamped pendulum: its speed follows the torque within a thousandth of a second.
TEST(Collocation, HandlesStiffSystemsWhereRungeKuttaDiverges) {
  const auto stiff = pendulum({.inertia = 1, .damping = 1000});
  constexpr double kStep = 0.02;
  constexpr int kSteps = 50;
  const std::vector<double> x{1, 0}, u{0};
  const std::vector<double> lost = March(stiff, Integrator::rk4).go(x, u, kStep, kSteps);
  EXPECT_FALSE(std::abs(lost[0]) < 1e3) << lost[0];
  const std::vector<double> exact = March(stiff, Integrator::rk4).go(x, u, 5e-4, 2000);
  for (const CollocationRule rule : kRules) {
    const std::vector<double> end =
        March(std::make_shared<CollocationSystem>(stiff, rule)).go(x, u, kStep, kSteps);
    EXPECT_NEAR(end[0], exact[0], 1e-3);
  }
}

// The trapezoidal rule alternates its sign at every step.
TEST(Collocation, RadauRulesDampInfinitelyStiffModes) {
  const auto stiff = pendulum({.inertia = 1, .damping = 1e9});
  const auto speed_after_one_step = [&](CollocationRule rule) {
    return March(std::make_shared<CollocationSystem>(stiff, rule)).go({0, 1}, {0}, 0.1, 1)[1];
  };
  EXPECT_NEAR(speed_after_one_step(CollocationRule::trapezoidal), -1, 1e-6);
  EXPECT_NEAR(speed_after_one_step(CollocationRule::radau3), 0, 1e-6);
  EXPECT_NEAR(speed_after_one_step(CollocationRule::radau5), 0, 1e-6);
}

/// A draining tank, x' = u − √x, and its second-order analogue, from empty: there the square root
/// has no derivative.
std::vector<Course> tanks() {
  const auto first = make_expression_system(
      {.states = {{.name = "x"}}, .controls = {{"u", "1"}}, .equations = {{"x", "u - sqrt(x)"}}});
  const auto second = make_expression_system({.kind = SystemKind::second_order,
                                              .states = {{.name = "q"}},
                                              .velocities = {{"v", "1"}},
                                              .controls = {{"u", "1"}},
                                              .equations = {{"v", "u - sqrt(q)"}}});
  return {{"first", first.system, {0}, {1}}, {"second", second.system, {0, 0}, {1}}};
}

TEST(Collocation, RadauRulesNeedNoInitialSlope) {
  for (const Course& tank : tanks())
    for (const CollocationRule rule : kRules) {
      ASSERT_TRUE(tank.system);
      March march(std::make_shared<CollocationSystem>(tank.system, rule));
      // All stages have slope 1.
      std::vector<double> w(march.model().nu(), 1.0);
      march.differentiate(tank.x, w, 0.1);
      const KnotWorkspace<double>& work = march.work();
      const bool radau = rule == CollocationRule::radau3 || rule == CollocationRule::radau5;
      const auto is_finite = [](const auto& values) {
        return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
      };
      EXPECT_EQ(is_finite(work.F()), radau) << tank.name;
      EXPECT_TRUE(is_finite(work.constraint)) << tank.name;
      EXPECT_EQ(is_finite(work.constraint_jacobian), radau) << tank.name;
    }
}

TEST(Collocation, NeedsAFlatStateSpaceAndASlope) {
  EXPECT_THROW(CollocationSystem(quadrotor({}), CollocationRule::trapezoidal),
               std::invalid_argument);
  EXPECT_THROW(CollocationSystem(car(2, 0.03), CollocationRule::hermite_simpson),
               std::invalid_argument);
}

TEST(Collocation, RejectsIntegratorsOfOtherRules) {
  const auto system =
      std::make_shared<CollocationSystem>(pendulum({}), CollocationRule::trapezoidal);
  EXPECT_NO_THROW(KnotModel(system, Integrator::trapezoidal));
  EXPECT_NO_THROW(KnotModel(system, Integrator::none));
  for (const Integrator other :
       {Integrator::hermite_simpson, Integrator::rk4, Integrator::semi_implicit_euler})
    EXPECT_THROW(KnotModel(system, other), std::invalid_argument);
  EXPECT_THROW(KnotModel(pendulum({}), Integrator::trapezoidal), std::invalid_argument);
}

TEST(Collocation, NamesItsSlopesAndTheirUnits) {
  const auto system =
      std::make_shared<CollocationSystem>(cartpole({}), CollocationRule::hermite_simpson);
  std::string names;
  for (const Column& column : system->control_columns())
    names += column.name + " " + column.unit + ", ";
  EXPECT_EQ(names,
            "force N, slope_middle/vx m/s², slope_middle/omega rad/s², slope_end/vx m/s², "
            "slope_end/omega rad/s², ");
}

}  // namespace
}  // namespace conddp
