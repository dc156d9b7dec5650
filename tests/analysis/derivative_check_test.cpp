#include "analysis/derivatives/derivative_check.hpp"

#include <set>
#include <type_traits>

#include <gtest/gtest.h>

#include "support/knot_case.hpp"

namespace conddp {
namespace {

/// r = (x₀², x₁ u₀) of flat states, with an error in its Jacobian.
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

/// A pendulum with ∂a/∂ω overestimated by 0.1 %.
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

TEST(DerivativeCheck, CorrectDerivativesPass) {
  const auto all = check_with(Mistake::kNone);
  ASSERT_EQ(all.size(), 3u);
  for (const DerivativeComparison& c : all) {
    EXPECT_LT(c.error, 1e-12);
    EXPECT_EQ(c.knots, (std::vector{0, 2, 4}));
  }
  EXPECT_EQ(find(all, DerivativeKind::dynamics).entries, 2 * 3 * 2 * 3);
  EXPECT_EQ(find(all, DerivativeKind::dynamics).term, -1);
  EXPECT_EQ(find(all, DerivativeKind::gradient).term, -1) << "of all costs";
}

TEST(DerivativeCheck, NamesAWrongJacobianOfAResidual) {
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

// The first and last nodes are displaced like the others.
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

TEST(DerivativeCheck, ComparesRequestedKnotsIncludingFirstAndLast) {
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

TEST(DerivativeCheck, NamesAColumnMissingFromTheStructure) {
  const DerivativeComparison c =
      find(check_with(Mistake::kMissingColumn), DerivativeKind::residual);
  EXPECT_EQ(c.error, 1);
  EXPECT_EQ(c.row, 1);
  EXPECT_EQ(c.column, 2);
  EXPECT_EQ(c.analytic, 0);
}

TEST(DerivativeCheck, NonFiniteDerivativesAreWrong) {
  EXPECT_EQ(find(check_with(Mistake::kNotFinite), DerivativeKind::residual).error,
            std::numeric_limits<double>::infinity());
}

TEST(DerivativeCheck, NamesWrongSystemDerivativeWithEveryIntegrator) {
  for (const Integrator integrator : integrators_of(SuspectPendulum())) {
    const auto model = std::make_shared<KnotModel>(std::make_shared<SuspectPendulum>(), integrator);
    const ShootingProblem problem = one_phase(model);
    const auto all = check_derivatives(problem, problem.create_trajectory());
    const DerivativeComparison& c = find(all, DerivativeKind::dynamics);
    EXPECT_GT(c.error, 1e-6) << static_cast<int>(integrator);
    EXPECT_EQ(c.column, 1) << static_cast<int>(integrator);
  }
}

TEST(DerivativeCheck, EverySystemPassesWithIntegratorsAndPreviousControl) {
  for (const auto& [name, system] : test_systems())
    for (const Integrator integrator : integrators_of(*system))
      for (const bool memory : {false, true}) {
        const bool impulse = integrator == Integrator::impulse;
        if (memory && impulse) continue;
        auto model = std::make_shared<KnotModel>(step_with(system, integrator, memory));
        model->add_cost("state", state_residual(model->manifold()), {});
        if (memory) model->add_cost("rate", control_rate_residual(*system), {});
        RandomNumbers random(5);
        const KnotCase c = make_case(name, model, random);
        Phase phase{
            .name = "only", .model = model, .dt = {impulse ? 0 : 0.05}, .cost_scale = {0.05}};
        phase.parameters = c.parameters;
        Phase terminal{
            .name = "terminal",
            .model = std::make_shared<KnotModel>(step_with(system, Integrator::none, memory)),
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

/// r = x₀² of a flat state, with half the correct derivative if `half`.
class SquareResidual : public ResidualBase<SquareResidual> {
 public:
  explicit SquareResidual(bool half) : ResidualBase({{1, {0}}}, 0, false), half_(half) {}
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    r[0] = in.x[0] * in.x[0];
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    jacobian[0] = in.x[0] * (half_ ? 1.0 : 2.0);
  }

 private:
  bool half_;
};

/// Two phases of three and five knots plus the terminal node, with the error in one of the three.
std::vector<DerivativeComparison> check_places(int mistake) {
  const auto system = pendulum({});
  const auto model_of = [&](int place, Integrator integrator) {
    auto model = std::make_shared<KnotModel>(system, integrator);
    model->add_cost("square", std::make_shared<SquareResidual>(place == mistake), {});
    return model;
  };
  const auto phase_of = [&](int place, int knots) {
    Phase phase{.name = "phase",
                .model = model_of(place, place < 2 ? Integrator::rk4 : Integrator::none)};
    phase.dt.assign(knots, place < 2 ? 0.1 : 0.0);
    phase.cost_scale.assign(knots, 1.0);
    phase.parameters.assign(knots, 1.0);
    return phase;
  };
  const ShootingProblem problem({0.7, 0.2}, {phase_of(0, 3), phase_of(1, 5)}, phase_of(2, 1));
  return check_derivatives(problem, problem.create_trajectory());
}

TEST(DerivativeCheck, ComparesEveryPhaseAndTheTerminalNode) {
  const std::vector<std::vector<int>> knots = {{0, 1, 2}, {3, 5, 7}, {8}};
  for (const int mistake : {-1, 0, 1, 2}) {
    const auto all = check_places(mistake);
    ASSERT_EQ(all.size(), 8u);  // no dynamics at the end
    std::set<std::pair<int, DerivativeKind>> wrong;
    for (const DerivativeComparison& c : all) {
      EXPECT_EQ(c.knots, knots[c.phase]) << mistake;
      EXPECT_GE(c.knot, c.knots.front());
      EXPECT_LE(c.knot, c.knots.back());
      if (c.error > 0.1)
        wrong.emplace(c.phase, c.kind);
      else
        EXPECT_LT(c.error, 1e-12) << mistake;
    }
    const std::set<std::pair<int, DerivativeKind>> expected = {{mistake, DerivativeKind::residual},
                                                               {mistake, DerivativeKind::gradient}};
    EXPECT_EQ(wrong, mistake < 0 ? decltype(wrong){} : expected) << mistake;
  }
}

// Small entries are compared relative to a thousandth of the largest entry. Gradients use the
// weights times unit residuals and derivatives.
TEST(DerivativeCheck, ErrorsScaleWithEntryAndLargestEntry) {
  auto model = std::make_shared<KnotModel>(pendulum({}), Integrator::rk4);
  model->add_cost("square", std::make_shared<SquareResidual>(true), {});
  for (const auto& [x, error] : {std::pair{4.0, 0.5}, {1e-5, 1e-5 / 1e-3}}) {
    Phase phase{.name = "only", .model = model, .dt = {0.1}, .cost_scale = {0.1}};
    phase.parameters = {3};
    const ShootingProblem problem(
        {x, 0}, {phase},
        {.name = "end",
         .model = std::make_shared<KnotModel>(model->shared_system(), Integrator::none),
         .dt = {0.0},
         .cost_scale = {1.0}});
    const auto all = check_derivatives(problem, problem.create_trajectory(), {.displacement = 0});
    const DerivativeComparison& c = find(all, DerivativeKind::residual);
    EXPECT_NEAR(c.error, error, 1e-12) << x;
    EXPECT_NEAR(c.analytic, x, 1e-12);
    EXPECT_NEAR(c.reference, 2 * x, 1e-12);
    EXPECT_EQ(c.entries, 2 + 1);  // state and control
    if (x < 1) continue;
    const DerivativeComparison& gradient = find(all, DerivativeKind::gradient);
    EXPECT_NEAR(gradient.analytic, 0.3 * x * x * x, 1e-12);
    EXPECT_NEAR(gradient.reference, 0.6 * x * x * x, 1e-12);
  }
}

// Weights 3 and 2 over 0.1 s: a thousandth of 0.5. Without weights: a thousandth of 1.
TEST(DerivativeCheck, GradientErrorsScaleWithAllWeights) {
  auto model = std::make_shared<KnotModel>(pendulum({}), Integrator::rk4);
  for (const char* name : {"one", "other"})
    model->add_cost(name, std::make_shared<SquareResidual>(true), {});
  const auto gradient_with = [&](double one, double other) {
    Phase phase{.name = "only", .model = model, .dt = {0.1}, .cost_scale = {0.1}};
    phase.parameters = {one, other};
    const ShootingProblem problem(
        {0.02, 0}, {phase},
        {.name = "end",
         .model = std::make_shared<KnotModel>(model->shared_system(), Integrator::none),
         .dt = {0.0},
         .cost_scale = {1.0}});
    return find(check_derivatives(problem, problem.create_trajectory(), {.displacement = 0}),
                DerivativeKind::gradient);
  };
  const DerivativeComparison both = gradient_with(3, 2);
  EXPECT_NEAR(both.reference, 0.5 * 2 * 8e-6, 1e-15);
  EXPECT_NEAR(both.analytic, 0.5 * 8e-6, 1e-15);
  EXPECT_NEAR(both.error, 8e-6 / 1e-3, 1e-12);
  EXPECT_EQ(gradient_with(0, 0).error, 0);
}

/// A pendulum whose acceleration contains the square root of its angle.
class RootPendulum : public SystemBase<RootPendulum> {
 public:
  RootPendulum() : SystemBase(SystemKind::second_order, StateManifold::flat(2), 1) {}
  template <class S>
  struct Data : SystemData<S> {
    explicit Data(const RootPendulum&) {}
  };
  template <class S>
  void evaluate_as(const S* x, const S* u, Data<S>& data) const {
    data.f[0] = u[0] + sqrt(x[0]);
  }
  template <class S>
  void differentiate_as(const S* x, const S* u, Data<S>& data) const {
    evaluate_as(x, u, data);
    data.fx[0] = S(0.5) / sqrt(x[0]);
    data.fx[1] = S(0.0);
    data.fu[0] = S(1.0);
  }
  template <class S>
  void update_kinematics_as(const S*, Data<S>&) const {}
};

/// r = √x₀ of a flat state.
class RootResidual : public ResidualBase<RootResidual> {
 public:
  RootResidual() : ResidualBase({{1, {0}}}, 0, false) {}
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    r[0] = sqrt(in.x[0]);
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    jacobian[0] = S(0.5) / sqrt(in.x[0]);
  }
};

// At 0.02 ± 0.1, the square root is defined at some knots only.
TEST(DerivativeCheck, SkipsNearbyPointsWithNonFiniteValues) {
  for (const bool constraint : {false, true}) {
    auto model = std::make_shared<KnotModel>(pendulum({}), Integrator::rk4);
    const auto root = std::make_shared<RootResidual>();
    if (constraint)
      model->add_constraint(make_constraint("root", root, ConstraintKind::bounds));
    else
      model->add_cost("root", root, {});
    ShootingProblem problem = one_phase(model, 30);
    problem.set_initial_state(std::vector<double>{0.02, 0});
    const auto all =
        check_derivatives(problem, problem.create_trajectory(), {.knots_per_phase = 30});
    const DerivativeComparison& c =
        find(all, constraint ? DerivativeKind::constraint : DerivativeKind::residual);
    EXPECT_LT(c.error, 1e-10);
    EXPECT_GT(c.entries, 30 * 3 + 5 * 3);
    EXPECT_LT(c.entries, 2 * 30 * 3 - 5 * 3);
    EXPECT_EQ(c.knots.size(), 30u);
  }
}

// Points without a finite successor are skipped too.
TEST(DerivativeCheck, SkipsNearbyPointsWithoutANextState) {
  const auto model = std::make_shared<KnotModel>(std::make_shared<RootPendulum>(),
                                                 Integrator::semi_implicit_euler);
  ShootingProblem problem = one_phase(model, 30);
  problem.set_initial_state(std::vector<double>{0.02, 0});
  const auto all = check_derivatives(problem, problem.create_trajectory(), {.knots_per_phase = 30});
  const DerivativeComparison& c = find(all, DerivativeKind::dynamics);
  EXPECT_LT(c.error, 1e-10);
  EXPECT_GT(c.entries, 30 * 6 + 5 * 6);
  EXPECT_LT(c.entries, 2 * 30 * 6 - 5 * 6);
}

/// r = x₀² with claimed second derivative `claim`.
class ClaimedSquare : public ResidualBase<ClaimedSquare> {
 public:
  explicit ClaimedSquare(double claim) : ResidualBase({{1, {0}}}, 0, false), claim_(claim) {}
  bool has_claimed_hessian() const override { return true; }
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    r[0] = in.x[0] * in.x[0];
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    jacobian[0] = in.x[0] * 2.0;
    if constexpr (std::is_same_v<S, Dual<Lane>>) jacobian[0].d = in.x[0].d * Lane(claim_);
  }

 private:
  double claim_;
};

/// x⁺ = (x₀ + 0.1 u₀², x₁ + u₁) with claimed second derivative `claim`.
class ClaimedSystem : public SystemBase<ClaimedSystem> {
 public:
  explicit ClaimedSystem(double claim)
      : SystemBase(SystemKind::discrete, StateManifold::flat(2), 2), claim_(claim) {}
  template <class S>
  struct Data : SystemData<S> {
    explicit Data(const ClaimedSystem&) {}
  };
  bool has_claimed_hessian() const override { return true; }
  template <class S>
  void evaluate_as(const S* x, const S* u, Data<S>& data) const {
    data.f[0] = x[0] + u[0] * u[0] * 0.1;
    data.f[1] = x[1] + u[1];
  }
  template <class S>
  void differentiate_as(const S* x, const S* u, Data<S>& data) const {
    evaluate_as(x, u, data);
    for (int i = 0; i < 4; ++i) {
      data.fx[i] = S(i % 3 == 0 ? 1.0 : 0.0);
      data.fu[i] = S(i == 3 ? 1.0 : 0.0);
    }
    data.fu[0] = u[0] * 0.2;
    if constexpr (std::is_same_v<S, Dual<Lane>>) data.fu[0].d = u[0].d * Lane(claim_);
  }
  template <class S>
  void update_kinematics_as(const S*, Data<S>&) const {}

 private:
  double claim_;
};

/// Claimed second derivatives of a system, of running costs and constraints, and of terminal ones.
struct Claims {
  double system = 0.2, cost = 2, constraint = 2, end_cost = 2, end_constraint = 2;
};

/// Compares the claims at a trajectory without zeros.
std::vector<DerivativeComparison> check_claims(const Claims& claims) {
  const auto system = std::make_shared<ClaimedSystem>(claims.system);
  const auto phase_of = [&](Integrator integrator, int knots, double cost, double constraint) {
    auto model = std::make_shared<KnotModel>(system, integrator);
    model->add_cost("cost", std::make_shared<ClaimedSquare>(cost), {});
    model->add_constraint(make_constraint("constraint", std::make_shared<ClaimedSquare>(constraint),
                                          ConstraintKind::bounds));
    Phase phase{.name = "phase", .model = model};
    for (int k = 0; k < knots; ++k) {
      phase.dt.push_back(0.1);
      phase.cost_scale.push_back(1);
      for (const double number : {1.0, -9.0, 9.0, 1.0}) phase.parameters.push_back(number);
    }
    return phase;
  };
  const ShootingProblem problem(
      {0.5, 0.3}, {phase_of(Integrator::discrete, 4, claims.cost, claims.constraint)},
      phase_of(Integrator::none, 1, claims.end_cost, claims.end_constraint));
  Trajectory trajectory = problem.create_trajectory();
  for (int k = 0; k < 4; ++k) trajectory.u(k) << 0.8, -0.4;
  return check_derivatives(problem, trajectory);
}

std::vector<DerivativeComparison> hessians_of(const std::vector<DerivativeComparison>& all) {
  std::vector<DerivativeComparison> hessians;
  for (const DerivativeComparison& c : all)
    if (c.kind == DerivativeKind::hessian)
      hessians.push_back(c);
    else
      EXPECT_LT(c.error, 1e-12);
  return hessians;
}

TEST(DerivativeCheck, CorrectSecondDerivativesPass) {
  const auto all = hessians_of(check_claims({}));
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].knots, (std::vector{0, 1, 3}));
  EXPECT_EQ(all[0].entries, 3 * 16);
  EXPECT_EQ(all[1].knots, (std::vector{4}));
  EXPECT_EQ(all[1].entries, 4);
  for (int phase = 0; phase < 2; ++phase) {
    EXPECT_EQ(all[phase].error, 0) << phase;
    EXPECT_EQ(all[phase].phase, phase);
    EXPECT_EQ(all[phase].term, -1) << "of the whole Lagrangian";
  }
}

// Multipliers are random, so they show in the ratio of the claim to the differences.
TEST(DerivativeCheck, NamesPlaceOfWrongSecondDerivative) {
  struct Case {
    Claims claims;
    int phase, place;
    double ratio;  ///< 0 for a sum
  };
  for (const Case& c : {Case{{.system = 0.25}, 0, 2, 1.25},
                        {{.cost = 3}, 0, 0, 0},
                        {{.constraint = 3}, 0, 0, 0},
                        {{.end_cost = 3}, 1, 0, 0},
                        {{.end_constraint = 3}, 1, 0, 0}}) {
    const auto all = hessians_of(check_claims(c.claims));
    ASSERT_EQ(all.size(), 2u);
    const DerivativeComparison &wrong = all[c.phase], &right = all[1 - c.phase];
    EXPECT_EQ(right.error, 0);
    EXPECT_GT(wrong.error, 1e-3);
    EXPECT_TRUE(wrong.displaced);
    EXPECT_EQ(wrong.row, c.place);
    EXPECT_EQ(wrong.column, c.place);
    if (c.ratio > 0) {
      EXPECT_NEAR(wrong.analytic, c.ratio * wrong.reference, 1e-6);
    }
  }
  // The cost is half the square: 6 x² and 7 x², next to a multiplier times 2.
  const DerivativeComparison end = hessians_of(check_claims({.end_cost = 3}))[1];
  EXPECT_GT(end.analytic - end.reference, 0.16 - 1e-6);  // (0.5 ± 0.1)²
  EXPECT_LT(end.analytic - end.reference, 0.36 + 1e-6);
  const DerivativeComparison row = hessians_of(check_claims({.end_constraint = 3}))[1];
  EXPECT_LT(std::abs(row.analytic - row.reference), 1 + 1e-6) << "multipliers are within ±1";
}

// If any function claims a Hessian, all are compared; otherwise none.
TEST(DerivativeCheck, ComparesHessiansIfOneFunctionClaimsOne) {
  const auto plain = linear_system(Eigen::Matrix2d::Identity(), Eigen::Matrix2d::Identity(),
                                   Eigen::Vector2d::Zero());
  const auto claiming = std::make_shared<ClaimedSystem>(0.2);
  enum class Claimant { kNone, kSystem, kCost, kConstraint, kEndCost, kEndConstraint };
  for (const Claimant who : {Claimant::kNone, Claimant::kSystem, Claimant::kCost,
                             Claimant::kConstraint, Claimant::kEndCost, Claimant::kEndConstraint}) {
    const auto phase_of = [&](Integrator integrator, Claimant cost, Claimant constraint) {
      std::shared_ptr<const System> system = plain;
      if (who == Claimant::kSystem && integrator != Integrator::none) system = claiming;
      const auto residual_of = [&](bool claims) -> std::shared_ptr<const Residual> {
        if (claims) return std::make_shared<ClaimedSquare>(2);
        return std::make_shared<SquareResidual>(false);
      };
      auto model = std::make_shared<KnotModel>(system, integrator);
      model->add_cost("cost", residual_of(who == cost), {});
      model->add_constraint(
          make_constraint("row", residual_of(who == constraint), ConstraintKind::bounds));
      return Phase{.name = "phase",
                   .model = model,
                   .dt = {0.1},
                   .cost_scale = {1},
                   .parameters = {1, -9, 9, 1}};
    };
    const ShootingProblem problem(
        {0.5, 0.3}, {phase_of(Integrator::discrete, Claimant::kCost, Claimant::kConstraint)},
        phase_of(Integrator::none, Claimant::kEndCost, Claimant::kEndConstraint));
    const auto all = check_derivatives(problem, problem.create_trajectory());
    EXPECT_EQ(hessians_of(all).size(), who == Claimant::kNone ? 0u : 2u) << static_cast<int>(who);
  }
}

// Finite differences may lose a ten-thousandth of a second derivative.
TEST(DerivativeCheck, SecondDerivativesAreComparedToATenThousandth) {
  for (const double share : {-0.9e-4, 0.9e-4})
    for (const auto& c : hessians_of(check_claims({.system = 0.2 * (1 + share)})))
      EXPECT_EQ(c.error, 0) << share;
  for (const double share : {-1.2e-4, 1.2e-4})
    EXPECT_NEAR(hessians_of(check_claims({.system = 0.2 * (1 + share)}))[0].error, 1.2e-4, 1e-6)
        << share;
}

}  // namespace
}  // namespace conddp
