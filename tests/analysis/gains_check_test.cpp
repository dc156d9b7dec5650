// Policies of linear-quadratic problems with open gaps away from the optimum, in matrix form.
#include "analysis/certificate/gains_check.hpp"

#include <gtest/gtest.h>

#include "analysis/certificate/check.hpp"
#include "analysis/certificate/lagrangian_gradient.hpp"
#include "analysis/derivatives/node_models.hpp"
#include "support/constrained_problems.hpp"
#include "support/linear_quadratic.hpp"

namespace conddp {
namespace {

using testing::LinearQuadratic;

/// A textbook sweep: K, k, and Q_uu of each knot, without costates. μ is added to all weights of
/// the model.
struct TextbookSweep {
  std::vector<Eigen::MatrixXd> K, Quu;
  std::vector<Eigen::VectorXd> k;

  TextbookSweep(const LinearQuadratic& lq, const Trajectory& t, const Eigen::MatrixXd& gap,
                double mu = 0)
      : K(lq.N()), Quu(lq.N()), k(lq.N()) {
    const auto with_weight = [&](const Eigen::VectorXd& diagonal) -> Eigen::MatrixXd {
      return (diagonal.array() + mu).matrix().asDiagonal();
    };
    Eigen::MatrixXd V = with_weight(lq.Qf);
    Eigen::VectorXd v = lq.Qf.cwiseProduct(t.x(lq.N()) - lq.xf_ref);
    for (int n = lq.N() - 1; n >= 0; --n) {
      const LinearQuadratic::Knot& knot = lq.knots[n];
      const Eigen::VectorXd next = v + V * gap.col(n);
      const Eigen::MatrixXd Qxx = with_weight(knot.Q) + knot.A.transpose() * V * knot.A;
      const Eigen::MatrixXd Qux = knot.B.transpose() * V * knot.A;
      Quu[n] = with_weight(knot.R) + knot.B.transpose() * V * knot.B;
      const Eigen::VectorXd qx =
          knot.Q.cwiseProduct(t.x(n) - knot.x_ref) + knot.A.transpose() * next;
      const Eigen::VectorXd qu = knot.R.cwiseProduct(t.u(n)) + knot.B.transpose() * next;
      const Eigen::LLT<Eigen::MatrixXd> factor(Quu[n]);
      K[n] = -factor.solve(Qux);
      k[n] = -factor.solve(qu);
      v = qx + K[n].transpose() * (Quu[n] * k[n] + qu) + Qux.transpose() * k[n];
      V = Qxx + K[n].transpose() * Quu[n] * K[n] + K[n].transpose() * Qux + Qux.transpose() * K[n];
    }
  }
};

/// A trajectory that violates the dynamics.
struct OpenTrajectory {
  explicit OpenTrajectory(unsigned seed)
      : lq(seed, 3, {2, 1}, 3, -testing::kFree, testing::kFree),
        t(testing::random_guess(*lq.problem, seed)),
        gap(lq.nx, lq.N()) {
    t.x(0) = lq.x0;
    for (int k = 0; k < lq.N(); ++k)
      gap.col(k) = lq.knots[k].A * t.x(k) + lq.knots[k].B * t.u(k) + lq.knots[k].c - t.x(k + 1);
    derivatives = node_derivatives(*lq.problem, t, gap);
  }
  SolutionClaims claims(const TextbookSweep& sweep, double mu) const {
    SolutionClaims claims(*lq.problem);
    claims.trajectory = t;
    claims.gains = sweep.K;
    claims.feedforward = sweep.k;
    claims.gain_regularization = mu;
    return claims;
  }
  std::string failures(const SolutionClaims& claims,
                       const DisplacedModel* displaced = nullptr) const {
    std::string names;
    for (const Check& check : checks(*lq.problem, claims, displaced))
      if (!check.holds) names += "[" + check.name + "]";
    return names;
  }

  std::vector<Check> checks(const ShootingProblem& problem, const SolutionClaims& claims,
                            const DisplacedModel* displaced = nullptr) const {
    return check_gains(problem, claims, derivatives, hessians(), gap, displaced);
  }

  std::vector<Eigen::MatrixXd> hessians() const { return gauss_newton_hessians(*lq.problem, t); }

  LinearQuadratic lq;
  Trajectory t;
  Eigen::MatrixXd gap;
  std::vector<NodeDerivatives> derivatives;
};

TEST(GainsOfASweep, MatchTextbookWithAndWithoutRegularization) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const OpenTrajectory at(seed);
    for (const double mu : {0.0, 0.8}) {
      const TextbookSweep sweep(at.lq, at.t, at.gap, mu);
      EXPECT_EQ(at.failures(at.claims(sweep, mu)), "") << seed << ' ' << mu;
      EXPECT_NE(at.failures(at.claims(sweep, mu + 0.01)), "") << seed << ' ' << mu;
    }
  }
}

TEST(GainsOfASweep, AreComparedEntryByEntry) {
  const OpenTrajectory at(2);
  const TextbookSweep sweep(at.lq, at.t, at.gap);
  SolutionClaims claims = at.claims(sweep, 0);
  for (int k = 0; k < at.lq.N(); ++k)
    for (Eigen::Index i = 0; i < sweep.k[k].size(); ++i) {
      // Policies of earlier knots depend on it too, but by no more than that.
      claims.feedforward[k][i] += 1e-4 * (1 + sweep.k[k].norm());
      EXPECT_EQ(at.failures(claims), "[feedforward]") << k << ' ' << i;
      claims.feedforward[k] = sweep.k[k];
      for (Eigen::Index j = 0; j < sweep.K[k].cols(); ++j) {
        claims.gains[k](i, j) += 1e-4 * sweep.K[k].norm();
        EXPECT_NE(at.failures(claims).find("[feedback]"), std::string::npos)
            << k << ": " << i << ", " << j;
        claims.gains[k](i, j) = sweep.K[k](i, j) + 1e-9 * sweep.K[k].norm();
        EXPECT_EQ(at.failures(claims), "") << "rounding";
        claims.gains[k] = sweep.K[k];
      }
    }
}

TEST(GainsOfASweep, AllowForModelChangeOnDisplacedTrajectory) {
  const OpenTrajectory at(2);
  OpenTrajectory moved(2);
  DisplacedModel displaced{at.t, at.derivatives, 1};
  for (int k = 0; k < at.lq.N(); ++k) {
    moved.lq.knots[k].A(0, 1) += 1e-3;
    displaced.derivatives[k].step(0, 1) += 1e-3;
  }
  const SolutionClaims claims = at.claims(TextbookSweep(moved.lq, at.t, at.gap), 0);
  EXPECT_NE(at.failures(claims).find("[feedback]"), std::string::npos);
  EXPECT_EQ(at.failures(claims, &displaced), "");
  displaced.margin = 1e-3;
  EXPECT_NE(at.failures(claims, &displaced).find("[feedback]"), std::string::npos);
}

/// Knots of one state and one control with steps x + u. Gains −0.5 and feedforward −1.5 solve the
/// equations Q_uu = 2, Q_ux = 1, and q_u = 3 of each knot.
struct NumberSweep {
  explicit NumberSweep(int knots)
      : lq(1, 1, {1}, knots, -testing::kFree, testing::kFree),
        claims(*lq.problem),
        gap(Eigen::MatrixXd::Zero(1, knots)) {
    for (int k = 0; k <= knots; ++k) {
      const int nz = k < knots ? 2 : 1;
      derivatives.push_back({Eigen::VectorXd::Zero(nz), Eigen::MatrixXd(0, nz),
                             Eigen::MatrixXd::Ones(k < knots ? 1 : 0, nz)});
      hessians.push_back(Eigen::MatrixXd::Zero(nz, nz));
    }
    claims.gains.assign(knots, Eigen::MatrixXd::Constant(1, 1, -0.5));
    claims.feedforward.assign(knots, Eigen::VectorXd::Constant(1, -1.5));
    claims.gain_regularization = 0;
  }
  void set_hessian(int k, double xx, double ux, double uu) { hessians[k] << xx, ux, ux, uu; }
  std::string failures() const {
    std::string names;
    for (const Check& check : check_gains(*lq.problem, claims, derivatives, hessians, gap))
      if (!check.holds) names += "[" + check.name + "]";
    return names;
  }
  /// Faults if the first knot's gain or feedforward equation is off by `off`.
  std::string with_gains_off(double off) {
    claims.gains[0](0, 0) = -0.5 + off / 2;
    const std::string found = failures();
    claims.gains[0](0, 0) = -0.5;
    return found;
  }
  std::string with_feedforward_off(double off) {
    claims.feedforward[0][0] = -1.5 + off / 2;
    const std::string found = failures();
    claims.feedforward[0][0] = -1.5;
    return found;
  }

  LinearQuadratic lq;
  SolutionClaims claims;
  Eigen::MatrixXd gap;
  std::vector<NodeDerivatives> derivatives;
  std::vector<Eigen::MatrixXd> hessians;
};

// Cancelling terms of 10¹² leave 10⁻¹⁴ of both: 0.02.
TEST(GainsOfASweep, AllowForRoundingOfCancellingTerms) {
  constexpr double kHuge = 1e12;
  NumberSweep sweep(1);
  sweep.hessians[1] << kHuge;
  sweep.set_hessian(0, -kHuge + 5, -kHuge + 1, -kHuge + 2);
  sweep.derivatives[0].cost << 0, 3;
  EXPECT_EQ(sweep.failures(), "");
  for (const double sign : {1.0, -1.0}) {
    EXPECT_EQ(sweep.with_gains_off(0.016 * sign), "");
    EXPECT_NE(sweep.with_gains_off(0.024 * sign).find("[feedback]"), std::string::npos);
    // The feedforward equation scales with the feedforward.
    EXPECT_EQ(sweep.with_feedforward_off(0.024 * sign), "");
    EXPECT_EQ(sweep.with_feedforward_off(0.036 * sign), "[feedforward]");
  }
}

TEST(GainsOfASweep, FeedforwardAllowsForRoundingOfCancellingGradients) {
  constexpr double kHuge = 1e12;
  for (const bool of_gap : {false, true}) {
    NumberSweep sweep(1);
    sweep.hessians[1] << 1;
    sweep.set_hessian(0, 1, 0, 1);
    sweep.derivatives[0].cost << 0, -kHuge + 3;
    if (of_gap)
      sweep.gap << kHuge;
    else
      sweep.derivatives[1].cost << kHuge;
    EXPECT_EQ(sweep.failures(), "") << of_gap;
    EXPECT_EQ(sweep.with_feedforward_off(0.016), "") << of_gap;
    EXPECT_EQ(sweep.with_feedforward_off(0.024), "[feedforward]") << of_gap;
    EXPECT_NE(sweep.with_gains_off(1e-4).find("[feedback]"), std::string::npos) << of_gap;
  }
}

// The next value contributes 0.02 (1 + 0.5²) = 0.025, times the closed loop 0.5 or the move −1.5.
TEST(GainsOfASweep, AllowForRoundingOfTheNextValue) {
  constexpr double kHuge = 1e12;
  NumberSweep sweep(2);
  sweep.hessians[2] << kHuge;
  sweep.set_hessian(1, -kHuge + 5, -kHuge + 1, -kHuge + 2);
  sweep.claims.feedforward[1] << 0;
  // Value: 5 + 0.25 · 2 − 2 · 0.5 = 4.5.
  sweep.set_hessian(0, 1, -3.5, -2.5);
  sweep.derivatives[0].cost << 0, 3;
  EXPECT_EQ(sweep.failures(), "");
  EXPECT_EQ(sweep.with_gains_off(0.0115), "");
  EXPECT_NE(sweep.with_gains_off(0.0135).find("[feedback]"), std::string::npos);
  EXPECT_EQ(sweep.with_feedforward_off(0.035), "");
  EXPECT_EQ(sweep.with_feedforward_off(0.041), "[feedforward]");
}

// The next slope contributes 0.02 (1 + 0.5) = 0.03.
TEST(GainsOfASweep, FeedforwardAllowsForRoundingOfTheNextSlope) {
  constexpr double kHuge = 1e12;
  NumberSweep sweep(2);
  sweep.hessians[2] << 1;
  sweep.set_hessian(1, 4, 0, 1);  // value: 5 + 0.25 · 2 − 2 · 0.5 = 4.5
  sweep.derivatives[2].cost << kHuge;
  sweep.derivatives[1].cost << -kHuge, -kHuge + 3;
  // Slope: 0 − 1.5 · 1 − 0.5 (3 − 1.5 · 2) = −1.5.
  sweep.set_hessian(0, 1, -3.5, -2.5);
  sweep.derivatives[0].cost << 0, 4.5;
  EXPECT_EQ(sweep.failures(), "");
  EXPECT_EQ(sweep.with_feedforward_off(0.027), "");
  EXPECT_EQ(sweep.with_feedforward_off(0.033), "[feedforward]");
}

// A displaced model with different derivatives but the Hessians of the problem. Its entries may be
// off by the margin times the change.
TEST(GainsOfASweep, AllowForChangesOfEachDerivative) {
  constexpr double kMargin = 10, kChange = 1e-4;
  NumberSweep sweep(1);
  const Trajectory t = sweep.lq.problem->create_trajectory();
  sweep.hessians = gauss_newton_hessians(*sweep.lq.problem, t);
  const double V = sweep.hessians[1](0, 0), Quu = V + sweep.hessians[0](1, 1);
  const auto failures_with = [&](const DisplacedModel& displaced, double gains_off,
                                 double feedforward_off) {
    sweep.claims.gains[0](0, 0) = (-V + gains_off) / Quu;
    sweep.claims.feedforward[0][0] = feedforward_off / Quu;
    std::string names;
    for (const Check& check : check_gains(*sweep.lq.problem, sweep.claims, sweep.derivatives,
                                          sweep.hessians, sweep.gap, &displaced))
      if (!check.holds) names += "[" + check.name + "]";
    return names;
  };
  DisplacedModel by_cost{t, sweep.derivatives, kMargin};
  by_cost.derivatives[0].cost[1] -= kChange;
  EXPECT_EQ(failures_with(by_cost, 0, 0.9 * kMargin * kChange), "");
  EXPECT_EQ(failures_with(by_cost, 0, 1.1 * kMargin * kChange), "[feedforward]");
  // J_uᵀ V J_x changes by V times the change of either factor, J_uᵀ V J_u by twice that of J_u.
  DisplacedModel by_state{t, sweep.derivatives, kMargin}, by_control = by_state;
  by_state.derivatives[0].step(0, 0) += kChange;
  by_control.derivatives[0].step(0, 1) -= kChange;
  const double once = kMargin * kChange * V;
  EXPECT_EQ(failures_with(by_state, 0.9 * once, 0), "");
  EXPECT_NE(failures_with(by_state, 1.1 * once, 0).find("[feedback]"), std::string::npos);
  EXPECT_EQ(failures_with(by_control, 1.9 * once, 0), "");
  EXPECT_NE(failures_with(by_control, 2.1 * once, 0).find("[feedback]"), std::string::npos);
}

// With only Q_uu = 1: a millionth of its rounding, and of it times the smallest move.
TEST(GainsOfASweep, AreWithinATolerance) {
  NumberSweep sweep(1);
  sweep.set_hessian(0, 0, 0, 1);
  sweep.claims.gains[0].setZero();
  sweep.claims.feedforward[0].setZero();
  const double feedback = 1e-6 * (1e-6 * 1.0), feedforward = 1e-6 * 1.0 * 1e-3;
  for (const double share : {1.0, -1.0, 1.02}) {
    sweep.set_hessian(0, 0, share * feedback, 1);
    EXPECT_EQ(sweep.failures(), share > 1 ? "[feedback]" : "") << share;
    sweep.set_hessian(0, 0, 0, 1);
    sweep.derivatives[0].cost[1] = share * feedforward;
    EXPECT_EQ(sweep.failures(), share > 1 ? "[feedforward]" : "") << share;
    sweep.derivatives[0].cost[1] = 0;
  }
  // A control of 4 and a feedforward of 0.01 give larger moves.
  sweep.claims.trajectory.u(0)[0] = 4;
  sweep.derivatives[0].cost[1] = 4.9 * feedforward;
  EXPECT_EQ(sweep.failures(), "");
  sweep.derivatives[0].cost[1] = 5.1 * feedforward;
  EXPECT_EQ(sweep.failures(), "[feedforward]");
  sweep.claims.feedforward[0][0] = 0.01;
  sweep.derivatives[0].cost[1] = -0.01 + 9.9 * feedforward;
  EXPECT_EQ(sweep.failures(), "");
  sweep.derivatives[0].cost[1] = -0.01 - 10.1 * feedforward;
  EXPECT_EQ(sweep.failures(), "[feedforward]");
}

TEST(GainsOfASweep, NamesKnotAndControlOfWrongGains) {
  for (const int k : {0, 1}) {
    NumberSweep sweep(2);
    for (int knot = 0; knot < 2; ++knot) sweep.set_hessian(knot, 0, 0, 1);
    for (Eigen::MatrixXd& K : sweep.claims.gains) K.setZero();
    for (Eigen::VectorXd& d : sweep.claims.feedforward) d.setZero();
    sweep.derivatives[k].cost[1] = 3;
    const auto checks =
        check_gains(*sweep.lq.problem, sweep.claims, sweep.derivatives, sweep.hessians, sweep.gap);
    ASSERT_EQ(checks.size(), 2u);
    EXPECT_TRUE(checks[0].holds);
    EXPECT_FALSE(checks[1].holds);
    EXPECT_EQ(checks[1].place,
              place_text(*sweep.lq.problem, k, control_name(*sweep.lq.problem, k, 0)));
    EXPECT_NE(checks[1].message.find("is off by 3, tolerance 1e-09"), std::string::npos)
        << checks[1].message;
  }
}

TEST(GainsOfASweep, AreSkippedForUnknownRegularization) {
  const OpenTrajectory at(3);
  const TextbookSweep sweep(at.lq, at.t, at.gap);
  const auto count = [&](double mu) {
    return at.checks(*at.lq.problem, at.claims(sweep, mu)).size();
  };
  EXPECT_EQ(count(0), 2u);
  EXPECT_EQ(count(SolutionClaims::kOpen), 0u);
  const ShootingProblem constrained = testing::with_constraints(
      *at.lq.problem, {testing::goal_constraint(*at.lq.problem, {0, 0, 0})});
  EXPECT_TRUE(at.checks(constrained, SolutionClaims(constrained)).empty());
}

TEST(GainsOfASweep, MayBeZeroForControlsAtABound) {
  const LinearQuadratic free(4, 3, {1}, 1, -testing::kFree, testing::kFree);
  const Trajectory t = testing::random_guess(*free.problem, 4);
  const LinearQuadratic::Knot& knot = free.knots[0];
  const Eigen::MatrixXd gap = knot.A * t.x(0) + knot.B * t.u(0) + knot.c - t.x(1);
  const TextbookSweep sweep(free, t, gap);
  for (const bool upper : {false, true})
    for (const double step : {0.25, 0.125}) {
      const double bound = t.u(0)[0] + 0.25;
      const LinearQuadratic bounded(4, 3, {1}, 1, upper ? -testing::kFree : bound,
                                    upper ? bound : testing::kFree);
      SolutionClaims claims(*bounded.problem);
      claims.trajectory = t;
      claims.gains = {Eigen::MatrixXd::Zero(1, 3)};
      claims.feedforward = {Eigen::VectorXd::Constant(1, step)};
      claims.gain_regularization = 0;
      const auto derivatives = node_derivatives(*bounded.problem, t, gap);
      const auto hessians = gauss_newton_hessians(*bounded.problem, t);
      const auto checks = [&] {
        return check_gains(*bounded.problem, claims, derivatives, hessians, gap);
      };
      for (const Check& check : checks()) EXPECT_EQ(check.holds, step == 0.25) << check.name;
      claims.gains = sweep.K;
      claims.feedforward = sweep.k;
      for (const Check& check : checks()) EXPECT_TRUE(check.holds) << check.name;
    }
}

// ∇_u L, costates along any policy, and the expected decrease of the model.
TEST(AdjointAlongAPolicy, MatchesItsDefinition) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const OpenTrajectory at(seed);
    const LinearQuadratic& lq = at.lq;
    const TextbookSweep sweep(lq, at.t, at.gap, 0.3);
    for (const bool with_gains : {false, true}) {
      const AdjointPass pass = adjoint_pass(*lq.problem, at.derivatives, Eigen::VectorXd(0),
                                            with_gains ? sweep.K : std::vector<Eigen::MatrixXd>{});
      Eigen::VectorXd costate = lq.Qf.cwiseProduct(at.t.x(lq.N()) - lq.xf_ref);
      EXPECT_LT((pass.costates.col(lq.N()) - costate).norm(), 1e-13);
      double largest = 0;
      for (int k = lq.N() - 1; k >= 0; --k) {
        const LinearQuadratic::Knot& knot = lq.knots[k];
        const Eigen::VectorXd control =
            knot.R.cwiseProduct(at.t.u(k)) + knot.B.transpose() * costate;
        costate =
            (knot.Q.cwiseProduct(at.t.x(k) - knot.x_ref) + knot.A.transpose() * costate).eval();
        if (with_gains) costate += sweep.K[k].transpose() * control;
        EXPECT_LT((pass.control[k] - control).norm(), 1e-12 * (1 + control.norm())) << k;
        EXPECT_LT((pass.costates.col(k) - costate).norm(), 1e-12 * (1 + costate.norm())) << k;
        largest = std::max(largest, control.lpNorm<Eigen::Infinity>());
      }
      EXPECT_GT(pass.rounding, 1e-2 * kAdjointRounding * largest);
      EXPECT_LT(pass.rounding, 1e4 * kAdjointRounding * largest);
    }
  }
}

TEST(RiccatiPolicy, MatchesTextbookForFreeControls) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const OpenTrajectory at(seed);
    const TextbookSweep sweep(at.lq, at.t, at.gap);
    const RiccatiPolicy policy =
        riccati_policy(*at.lq.problem, at.t, at.derivatives, at.hessians());
    EXPECT_TRUE(policy.convex);
    double decrease = 0;
    std::vector<Eigen::VectorXd> gradient;
    for (int k = 0; k < at.lq.N(); ++k) {
      EXPECT_LT((policy.K[k] - sweep.K[k]).norm(), 1e-10) << k;
      EXPECT_LT((policy.inverse[k] * sweep.Quu[k] -
                 Eigen::MatrixXd::Identity(sweep.Quu[k].rows(), sweep.Quu[k].cols()))
                    .norm(),
                1e-11)
          << k;
      gradient.push_back(Eigen::VectorXd::LinSpaced(sweep.k[k].size(), 1 + k, 2));
      decrease += 0.5 * gradient[k].dot(sweep.Quu[k].llt().solve(gradient[k]));
    }
    EXPECT_NEAR(policy.decrease(gradient), decrease, 1e-11 * decrease);
  }
}

// The second of two controls is at its bound at every knot. Its rows are zero; the others match a
// problem without it.
TEST(RiccatiPolicy, ExcludesControlsAtTheirBounds) {
  const OpenTrajectory at(5);
  LinearQuadratic reduced(5, 3, {2, 1}, 3, -testing::kFree, testing::kFree);
  Trajectory t = at.t;
  for (int k = 0; k < 3; ++k) {
    t.u(k)[1] = -0.75;
    reduced.knots[k].B.col(1).setZero();
  }
  std::vector<Phase> phases = at.lq.problem->phases();
  auto held = std::make_shared<KnotModel>(*phases[0].model);
  held->set_control_bounds({-testing::kFree, -0.75}, {testing::kFree, 3});
  phases[0].model = held;
  const ShootingProblem bounded(at.lq.problem->initial_state(), std::move(phases),
                                at.lq.problem->terminal());
  const RiccatiPolicy policy = riccati_policy(bounded, t, node_derivatives(bounded, t, at.gap),
                                              gauss_newton_hessians(bounded, t));
  const TextbookSweep sweep(reduced, t, at.gap);
  for (int k = 0; k < at.lq.N(); ++k) EXPECT_LT((policy.K[k] - sweep.K[k]).norm(), 1e-10) << k;
  for (int k = 0; k < 3; ++k) {
    EXPECT_TRUE(policy.K[k].row(1).isZero(0));
    EXPECT_TRUE(policy.inverse[k].row(1).isZero(0) && policy.inverse[k].col(1).isZero(0));
    EXPECT_NEAR(policy.inverse[k](0, 0) * sweep.Quu[k](0, 0), 1, 1e-12);
  }
}

TEST(RiccatiPolicy, ReportsStagesWithoutAMinimum) {
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(1, 1);
  const ShootingProblem problem =
      testing::tracking_problem(linear_system(one, one, Eigen::VectorXd::Zero(1)),
                                Integrator::discrete, 2, 1, {0}, {{1}, {0}, {0}, {0}, false});
  const Trajectory t = problem.create_trajectory();
  const RiccatiPolicy policy =
      riccati_policy(problem, t, node_derivatives(problem, t, Eigen::MatrixXd::Zero(1, 2)),
                     gauss_newton_hessians(problem, t));
  EXPECT_FALSE(policy.convex);
  EXPECT_EQ(policy.K[0](0, 0), 0);
  EXPECT_TRUE(std::isnan(policy.decrease({one.col(0), one.col(0)})));
}

}  // namespace
}  // namespace conddp
