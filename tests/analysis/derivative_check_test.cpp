#include "analysis/certificate/derivative_check.hpp"

#include <gtest/gtest.h>

#include "support/knot_case.hpp"

namespace conddp {
namespace {

/// r = (x₀², x₁ u₀) of flat states, with a mistake in its Jacobian.
class SuspectResidual : public ResidualBase<SuspectResidual> {
 public:
  enum class Mistake { kNone, kSign, kMissingColumn, kNotFinite };
  SuspectResidual(int ndx, Mistake mistake)
      : ResidualBase(
            {{1, {0}},
             {1, mistake == Mistake::kMissingColumn ? std::vector{1} : std::vector{1, ndx}}},
            0, true),
        mistake_(mistake) {}
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    r[0] = in.x[0] * in.x[0];
    r[1] = in.x[1] * in.u[0];
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    jacobian[0] = in.x[0] * 2.0;
    jacobian[1] = in.u[0] * (mistake_ == Mistake::kSign ? -1.0 : 1.0);
    if (mistake_ != Mistake::kMissingColumn) jacobian[2] = in.x[1];
    if (mistake_ == Mistake::kNotFinite) jacobian[2] = S(1.0) / S(0.0);
  }

 private:
  Mistake mistake_;
};
using Mistake = SuspectResidual::Mistake;

/// A pendulum whose ∂a/∂ω is 0.1 % too large.
class SuspectPendulum : public SystemBase<SuspectPendulum> {
 public:
  SuspectPendulum() : SystemBase(SystemKind::second_order, StateManifold::flat(2), 1) {}
  template <class S>
  struct Data : SystemData<S> {
    explicit Data(const SuspectPendulum&) {}
  };
  template <class S>
  void evaluate_as(const S* x, const S* u, Data<S>& data) const {
    data.f[0] = u[0] - sin(x[0]) - x[1] * 0.1;
  }
  template <class S>
  void differentiate_as(const S* x, const S* u, Data<S>& data) const {
    evaluate_as(x, u, data);
    data.fx[0] = -cos(x[0]);
    data.fx[1] = S(-0.1001);
    data.fu[0] = S(1.0);
  }
  template <class S>
  void update_kinematics_as(const S*, Data<S>&) const {}
};

ShootingProblem one_phase(const std::shared_ptr<KnotModel>& model, int knots = 5) {
  Phase phase{.name = "only", .model = model};
  phase.dt.assign(knots, 0.1);
  phase.cost_scale.assign(knots, 0.1);
  const std::size_t n = model->parameter_count();
  phase.parameters.assign(knots * n, 0.0);
  for (int k = 0; k < knots; ++k) {
    for (const CostTerm& term : model->costs()) phase.parameters[k * n + term.weight] = 1;
    for (const ConstraintTerm& term : model->constraints())
      phase.parameters[k * n + term.active()] = 1;
  }
  Phase terminal{.name = "terminal",
                 .model = std::make_shared<KnotModel>(model->shared_system(), Integrator::none),
                 .dt = {0.0},
                 .cost_scale = {1.0}};
  return {std::vector<double>(model->nx(), 0.0), {phase}, terminal};
}

std::vector<DerivativeComparison> check_with(Mistake mistake) {
  auto model = std::make_shared<KnotModel>(pendulum({}), Integrator::rk4);
  model->add_cost("suspect", std::make_shared<SuspectResidual>(model->ndx(), mistake), {});
  const ShootingProblem problem = one_phase(model);
  return check_derivatives(problem, problem.create_trajectory());
}

const DerivativeComparison& find(const std::vector<DerivativeComparison>& all,
                                 DerivativeKind kind) {
  for (const DerivativeComparison& c : all)
    if (c.kind == kind) return c;
  throw std::logic_error("there is no such derivative");
}

TEST(DerivativeCheck, ConstraintsAreComparedByTheirNames) {
  const auto compared = [](Mistake mistake) {
    auto model = std::make_shared<KnotModel>(pendulum({}), Integrator::rk4);
    const auto add = [&](const char* name, Mistake kind) {
      model->add_constraint(make_constraint(
          name, std::make_shared<SuspectResidual>(model->ndx(), kind), ConstraintKind::bounds));
    };
    add("other", Mistake::kNone);
    add("suspect", Mistake::kNone);
    add("suspect", mistake);
    const ShootingProblem problem = one_phase(model);
    return check_derivatives(problem, problem.create_trajectory());
  };
  const auto right = compared(Mistake::kNone);
  ASSERT_EQ(right.size(), 3u);  // dynamics and two constraints
  EXPECT_EQ(right[1].kind, DerivativeKind::constraint);
  EXPECT_EQ(right[2].term, 1);
  for (const DerivativeComparison& c : right) EXPECT_LT(c.error, 1e-12);
  const auto wrong = compared(Mistake::kSign);
  EXPECT_LT(wrong[1].error, 1e-12);
  EXPECT_GT(wrong[2].error, 1);
}

TEST(DerivativeCheck, RightDerivativesAreRight) {
  const auto all = check_with(Mistake::kNone);
  ASSERT_EQ(all.size(), 3u);
  for (const DerivativeComparison& c : all) {
    EXPECT_LT(c.error, 1e-12);
    EXPECT_EQ(c.knots, (std::vector{0, 2, 4}));
  }
  EXPECT_EQ(find(all, DerivativeKind::dynamics).entries, 2 * 3 * 2 * 3);
}

TEST(DerivativeCheck, AWrongJacobianOfAResidualIsNamed) {
  const auto all = check_with(Mistake::kSign);
  const DerivativeComparison& c = find(all, DerivativeKind::residual);
  EXPECT_GT(c.error, 1);
  EXPECT_EQ(c.term, 0);
  EXPECT_EQ(c.row, 1);
  EXPECT_EQ(c.column, 1);
  EXPECT_TRUE(c.displaced);  // at u = 0 both are zero
  EXPECT_DOUBLE_EQ(c.analytic, -c.reference);
  EXPECT_GT(find(all, DerivativeKind::gradient).error, 1e-3);
  EXPECT_LT(find(all, DerivativeKind::dynamics).error, 1e-12);
}

// The first node moves as the others do, and so does the last one.
TEST(DerivativeCheck, EveryNodeIsDisplaced) {
  auto model = std::make_shared<KnotModel>(pendulum({}), Integrator::rk4);
  model->add_cost("suspect", std::make_shared<SuspectResidual>(model->ndx(), Mistake::kSign), {});
  const ShootingProblem one = one_phase(model, 1);
  const auto check_one = [&](double displacement) {
    return find(check_derivatives(one, one.create_trajectory(), {.displacement = displacement}),
                DerivativeKind::residual);
  };
  EXPECT_EQ(check_one(0).error, 0) << "at rest both are zero";
  EXPECT_FALSE(check_one(0).displaced);
  const DerivativeComparison c = check_one(0.1);
  EXPECT_EQ(c.knot, 0);
  EXPECT_TRUE(c.displaced);
  EXPECT_GT(c.error, 1);
  EXPECT_LE(std::abs(c.reference), 0.1);
}

TEST(DerivativeCheck, AsManyKnotsOfAPhaseAsAskedForAreComparedFirstAndLastAmongThem) {
  auto model = std::make_shared<KnotModel>(pendulum({}), Integrator::rk4);
  const ShootingProblem problem = one_phase(model, 9);
  const auto knots = [&](int count) {
    return find(check_derivatives(problem, problem.create_trajectory(), {.knots_per_phase = count}),
                DerivativeKind::dynamics)
        .knots;
  };
  EXPECT_EQ(knots(1), (std::vector{0}));
  EXPECT_EQ(knots(2), (std::vector{0, 8}));
  EXPECT_EQ(knots(5), (std::vector{0, 2, 4, 6, 8}));
  EXPECT_EQ(knots(100), (std::vector{0, 1, 2, 3, 4, 5, 6, 7, 8}));
}

TEST(DerivativeCheck, AColumnThatTheStructureForgetsIsNamed) {
  const DerivativeComparison c =
      find(check_with(Mistake::kMissingColumn), DerivativeKind::residual);
  EXPECT_EQ(c.error, 1);
  EXPECT_EQ(c.row, 1);
  EXPECT_EQ(c.column, 2);
  EXPECT_EQ(c.analytic, 0);
}

TEST(DerivativeCheck, WhatIsNotFiniteIsWrong) {
  EXPECT_EQ(find(check_with(Mistake::kNotFinite), DerivativeKind::residual).error,
            std::numeric_limits<double>::infinity());
}

TEST(DerivativeCheck, AWrongDerivativeOfASystemIsNamedWithEveryIntegrator) {
  for (const Integrator integrator : integrators_of(SuspectPendulum())) {
    const auto model = std::make_shared<KnotModel>(std::make_shared<SuspectPendulum>(), integrator);
    const ShootingProblem problem = one_phase(model);
    const auto all = check_derivatives(problem, problem.create_trajectory());
    const DerivativeComparison& c = find(all, DerivativeKind::dynamics);
    EXPECT_GT(c.error, 1e-6) << static_cast<int>(integrator);
    EXPECT_EQ(c.column, 1) << static_cast<int>(integrator);
  }
}

TEST(DerivativeCheck, EverySystemPassesWithEveryIntegratorAndPreviousControl) {
  for (const auto& [name, system] : test_systems())
    for (const Integrator integrator : integrators_of(*system))
      for (const bool memory : {false, true}) {
        const bool impulse = integrator == Integrator::impulse;
        if (memory && impulse) continue;
        auto model = std::make_shared<KnotModel>(system, integrator, memory_of(memory));
        model->add_cost("state", state_residual(model->manifold()), {});
        if (memory) model->add_cost("rate", control_rate_residual(*system), {});
        RandomNumbers random(5);
        const KnotCase c = make_case(name, model, random);
        Phase phase{
            .name = "only", .model = model, .dt = {impulse ? 0 : 0.05}, .cost_scale = {0.05}};
        phase.parameters = c.parameters;
        Phase terminal{
            .name = "terminal",
            .model = std::make_shared<KnotModel>(system, Integrator::none, memory_of(memory)),
            .dt = {0.0},
            .cost_scale = {1.0}};
        const ShootingProblem problem(c.x, {phase}, terminal);
        for (const DerivativeComparison& d :
             check_derivatives(problem, problem.create_trajectory()))
          EXPECT_LT(d.error, 1e-8) << name << " " << static_cast<int>(d.kind) << " integrator "
                                   << static_cast<int>(integrator) << ": d " << d.row << " / d "
                                   << d.column << " is " << d.analytic << ", not " << d.reference;
      }
}

}  // namespace
}  // namespace conddp
