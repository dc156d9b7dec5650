// Solver answers pass all checks; changing one number makes the corresponding check fail.
#include <functional>

#include <gtest/gtest.h>

#include "analysis/certificate/certificate.hpp"
#include "analysis/certificate/certificate_doubt.hpp"
#include "analysis/certificate/check.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/small_problems.hpp"

namespace conddp {
namespace {

std::string failed_checks(const ShootingProblem& problem, const SolutionClaims& claims) {
  std::string names;
  for (const Check& check : certify(problem, claims).checks)
    if (!check.holds) names += "[" + check.name + "]";
  return names;
}

struct Answer {
  explicit Answer(ShootingProblem of, const char* solver = "box_fddp")
      : problem(std::move(of)),
        result(solve(problem, solver, {}, problem.create_trajectory())),
        claims(claims_of(problem, result, NodeValues(problem, result.trajectory), {})) {}
  ShootingProblem problem;
  SolveResult result;
  SolutionClaims claims;
};

TEST(CertificateOfSolves, HoldsForAnswersWithBoundsAndContacts) {
  for (const auto& make : std::vector<std::function<ShootingProblem()>>{
           [] { return testing::pendulum_swing_up(3); }, [] { return testing::unicycle_parking(); },
           [] { return testing::unicycle_parking(2); },
           [] { return testing::quadrotor_move(0, 6); }, [] { return testing::landing(); }}) {
    const Answer answer(make());
    ASSERT_EQ(answer.result.status, SolveStatus::converged) << answer.result.message;
    EXPECT_EQ(failed_checks(answer.problem, answer.claims), "");
    EXPECT_TRUE(certify(answer.problem, answer.claims).holds());
  }
}

// Rounding grows with the magnitude of the answer, and the tolerances grow with it.
TEST(CertificateOfSolves, IsIndependentOfCostUnits) {
  for (const double unit : {1e-6, 1.0, 1e6}) {
    const auto scaled = [unit](std::vector<double> weights) {
      for (double& w : weights) w *= unit;
      return weights;
    };
    const Answer answer(testing::tracking_problem(
        unicycle(), Integrator::rk4, 30, 0.1, {0, 0, 0},
        {{3, 3, 0}, scaled({1, 1, 1}), scaled({0.5, 0.5}), scaled({10, 10, 10})}, -2, 2));
    EXPECT_EQ(failed_checks(answer.problem, answer.claims), "") << unit;
    SolutionClaims changed = answer.claims;
    changed.cost *= 1 + 1e-7;
    EXPECT_EQ(failed_checks(answer.problem, changed), "[cost]") << unit;
    changed = answer.claims;
    changed.state_gradient(0, 10) += 1e-6 * unit;
    EXPECT_EQ(failed_checks(answer.problem, changed), "[co-states]") << unit;
  }
}

TEST(CertificateOfSolves, ComparesEveryGain) {
  for (const double limit : {testing::kFree, 2.0}) {
    const Answer answer(testing::unicycle_parking(limit));
    SolutionClaims changed = answer.claims;
    for (const int k : {0, 37, 99})
      for (int i = 0; i < 2; ++i) {
        const Eigen::MatrixXd K = changed.gains[k];
        if (K.row(i).isZero(0)) continue;  // held at its bound
        for (int j = 0; j < 3; ++j) {
          changed.gains[k](i, j) += 2e-4 * K.cwiseAbs().maxCoeff();
          EXPECT_EQ(failed_checks(answer.problem, changed), "[feedback]")
              << "knot " << k << ", K(" << i << ", " << j << ")";
          changed.gains[k] = K;
        }
        const double step = changed.feedforward[k][i];
        changed.feedforward[k][i] += 1e-3 * (1 + answer.claims.trajectory.u(k).norm());
        EXPECT_EQ(failed_checks(answer.problem, changed), "[feedforward]")
            << "knot " << k << ", k(" << i << ")";
        changed.feedforward[k][i] = step;
      }
  }
}

TEST(CertificateOfSolves, ComparesEachFigureWithItsOwnValue) {
  const Answer answer(testing::pendulum_swing_up(3));
  const auto after = [&](const std::function<void(SolutionClaims&)>& change) {
    SolutionClaims changed = answer.claims;
    change(changed);
    return failed_checks(answer.problem, changed);
  };
  EXPECT_EQ(after([](SolutionClaims& c) { c.cost += 1e-7; }), "[cost]");
  EXPECT_EQ(after([](SolutionClaims& c) { c.cost_by_name[0].second += 1e-7; }), "[cost state]");
  EXPECT_EQ(after([](SolutionClaims& c) { c.cost_by_name.pop_back(); }), "[cost terminal/state]");
  EXPECT_EQ(after([](SolutionClaims& c) { c.cost_by_name.emplace_back("more", 0); }),
            "[cost more]");
  EXPECT_EQ(after([](SolutionClaims& c) { c.times[20] += 1e-9; }), "[times]");
  EXPECT_EQ(after([](SolutionClaims& c) { c.stationarity += 1e-9; }), "[stationarity]");
  EXPECT_EQ(after([](SolutionClaims& c) { c.gap += 5e-10; }), "[gap]");
  EXPECT_EQ(after([](SolutionClaims& c) { c.constraint += 1e-9; }), "[constraint violation]");
  EXPECT_EQ(after([](SolutionClaims& c) { c.complementarity += 1e-9; }), "[complementarity]");
  EXPECT_EQ(after([](SolutionClaims& c) { c.state_gradient(1, 20) += 1e-6; }), "[co-states]");
  EXPECT_EQ(after([](SolutionClaims& c) { c.converged = false; }), "[status]");
  EXPECT_EQ(after([](SolutionClaims& c) { c.cost = SolutionClaims::kOpen; }), "[cost]");
  EXPECT_NE(after([](SolutionClaims& c) { c.trajectory.x(0)[1] += 1e-9; }).find("[initial state]"),
            std::string::npos);
  EXPECT_NE(after([](SolutionClaims& c) { c.costates(0, 20) += 1e-3; }).find("[stationarity]"),
            std::string::npos);
  EXPECT_NE(after([](SolutionClaims& c) { c.trajectory.x(20)[0] += 1e-3; }).find("[gap]"),
            std::string::npos);
}

TEST(CertificateOfSolves, ComparesInitialStateAndTimesEntryByEntry) {
  const Answer answer(testing::quadrotor_move(0, 6));
  const int N = answer.problem.knots();
  for (int i = 0; i < answer.problem.ndx(); ++i) {
    SolutionClaims changed = answer.claims;
    double* x = changed.trajectory.x(0).data();
    const Eigen::VectorXd dx = 1e-9 * Eigen::VectorXd::Unit(answer.problem.ndx(), i);
    answer.problem.manifold().integrate(x, dx.data(), x);
    EXPECT_NE(failed_checks(answer.problem, changed).find("[initial state]"), std::string::npos)
        << i;
  }
  for (const int k : {0, N / 2, N}) {
    SolutionClaims changed = answer.claims;
    changed.times[k] -= 1e-9;
    EXPECT_EQ(failed_checks(answer.problem, changed), "[times]") << k;
    changed = answer.claims;
    changed.trajectory.x(k).segment(3, 4) *= 1 + 1e-7;
    EXPECT_NE(failed_checks(answer.problem, changed).find("[unit quaternions]"), std::string::npos)
        << k;
  }
}

TEST(CertificateOfSolves, ComparesEveryCostateAndControl) {
  const Answer answer(testing::quadrotor_move(0, 6));
  const int N = answer.problem.knots();
  for (const int k : {0, 1, N})
    for (int i = 0; i < answer.problem.ndx(); ++i) {
      SolutionClaims changed = answer.claims;
      changed.state_gradient(i, k) += 1e-6;
      EXPECT_EQ(failed_checks(answer.problem, changed), "[co-states]") << k << ' ' << i;
    }
  for (const int k : {0, N - 1})
    for (int i = 0; i < 4; ++i) {
      SolutionClaims changed = answer.claims;
      changed.lower_multipliers[k][i] += 1e-3;
      EXPECT_NE(failed_checks(answer.problem, changed).find("[stationarity]"), std::string::npos)
          << k << ' ' << i;
    }
}

/// An answer that ended in extremely large numbers.
TEST(CertificateOfSolves, DivergedAnswersMayOmitButNotForgeFigures) {
  const Answer answer(testing::pendulum_swing_up(3));
  SolutionClaims claims = answer.claims;
  claims.converged = false;
  claims.status = "diverged";
  claims.stationarity += 1;  // above its tolerance, and wrong
  EXPECT_EQ(failed_checks(answer.problem, claims), "[stationarity]");
  claims.stationarity = SolutionClaims::kOpen;
  claims.cost = SolutionClaims::kOpen;
  EXPECT_EQ(failed_checks(answer.problem, claims), "");
  claims.status = "max_iterations";
  EXPECT_NE(failed_checks(answer.problem, claims), "");
}

/// x⁺ = x + B u from 1; a solver without iterations leaves it there.
struct AtRest {
  ShootingProblem problem;
  SolveResult result;
  SolutionClaims claims;

  AtRest(double B, double control_weight, double stationarity)
      : problem(testing::tracking_problem(
            linear_system(Eigen::MatrixXd::Identity(1, 1), Eigen::MatrixXd::Constant(1, 1, B),
                          Eigen::VectorXd::Zero(1)),
            Integrator::discrete, 5, 1, {1}, {{0}, {0.1}, {control_weight}, {0.1}, false})),
        result(solve(problem, "box_fddp", options(stationarity),
                     testing::constant_controls(problem, 0))),
        claims(claims_of(problem, result, NodeValues(problem, result.trajectory),
                         options(stationarity))) {}

  static SolverOptions options(double stationarity) {
    SolverOptions options;
    options.tolerances.stationarity = stationarity;
    options.max_iterations = 0;
    return options;
  }
};

// Loose tolerance; most of the cost could still be gained.
TEST(CertificateOfSolves, RejectsConvergedIfMuchGainRemains) {
  AtRest at(1, 0.1, 10);
  ASSERT_EQ(at.result.status, SolveStatus::max_iterations) << at.result.message;
  EXPECT_EQ(failed_checks(at.problem, at.claims), "");
  at.claims.converged = true;
  at.claims.status = "converged";
  EXPECT_EQ(failed_checks(at.problem, at.claims), "[status]");
}

// Controls without effect or cost: no solver can estimate the distance to a minimum.
TEST(CertificateOfSolves, UnknownGainLeavesConvergedOptional) {
  AtRest at(0, 0, 1e-6);
  ASSERT_NE(at.result.status, SolveStatus::diverged) << at.result.message;
  for (const bool converged : {false, true}) {
    at.claims.converged = converged;
    at.claims.status = converged ? "converged" : "max_iterations";
    EXPECT_EQ(failed_checks(at.problem, at.claims), "") << at.claims.status;
  }
}

TEST(CertificateOfSolves, PlacesNameKnotPhaseAndItem) {
  const Answer answer(testing::landing());
  SolutionClaims changed = answer.claims;
  changed.tangent_names = {"x", "z", "pitch", "hip", "knee", "vx", "vz", "wp", "wh", "wk"};
  changed.trajectory.x(3)[4] += 0.5;
  changed.gap = 0;
  std::string place;
  for (const Check& check : certify(answer.problem, changed).checks)
    if (check.name == "gap") place = check.place;
  EXPECT_NE(place.find("phase 'flight'"), std::string::npos) << place;
}

TEST(PlaceText, NamesKnotsAndTheLastNode) {
  const ShootingProblem problem = testing::landing();
  EXPECT_EQ(place_text(problem, 0, ""), "knot 0 (phase 'flight')");
  EXPECT_EQ(place_text(problem, 9, "vz"), "knot 9 (phase 'flight'), vz");
  EXPECT_EQ(place_text(problem, 10, ""), "knot 10 (phase 'touch_down')");
  EXPECT_EQ(place_text(problem, 40, ""), "knot 40 (phase 'stance')");
  EXPECT_EQ(place_text(problem, 41, "x"), "knot 41 (the last node), x");
}

TEST(PlaceText, ControlsAreNamedIfNamesExist) {
  const ShootingProblem problem = testing::landing();
  EXPECT_EQ(control_name(problem, 0, 0), "u/hip");
  EXPECT_EQ(control_name(problem, 0, 1), "u/knee");
  EXPECT_EQ(control_name(problem, 0, 2), "");
  EXPECT_EQ(control_name(problem, 0, -1), "");
  EXPECT_EQ(control_name(problem, -1, 0), "");
  EXPECT_EQ(control_name(problem, 10, 0), "") << "an impulse has none";
  EXPECT_EQ(control_name(problem, 40, 1), "u/knee");
  EXPECT_EQ(control_name(problem, 41, 0), "");
}

TEST(CertificateOfSolves, QuaternionsHaveUnitLength) {
  const Answer answer(testing::quadrotor_move(0, 6));
  SolutionClaims changed = answer.claims;
  changed.trajectory.x(7).segment(3, 4) *= 1 + 1e-7;
  EXPECT_NE(failed_checks(answer.problem, changed).find("[unit quaternions]"), std::string::npos);
  EXPECT_FALSE(certify(answer.problem, changed).holds());
}

TEST(LastJudged, IsTakenOverForTheSameAnswerOnly) {
  const Answer answer(testing::pendulum_swing_up(3));
  const NodeValues values(answer.problem, answer.result.trajectory);
  LastJudged last;
  const auto is_taken_over = [&](const SolutionClaims& claims) {
    return certify(answer.problem, claims, values, &last).checks.front().name == "mark";
  };
  EXPECT_FALSE(is_taken_over(answer.claims));
  last.emplace(answer.claims, Certificate{.checks = {{"mark"}}});
  EXPECT_TRUE(is_taken_over(answer.claims));
  const std::function<void(SolutionClaims&)> changes[] = {
      [](SolutionClaims& c) { c.trajectory.u(3)[0] += 1e-15; },
      [](SolutionClaims& c) { c.cost = SolutionClaims::kOpen; },
      [](SolutionClaims& c) { c.status = "diverged"; },
      [](SolutionClaims& c) { c.gains[2](0, 1) *= 2; },
      [](SolutionClaims& c) { c.costates(1, 4) = 0; },
      [](SolutionClaims& c) { c.tolerances.gap *= 2; },
      [](SolutionClaims& c) {
        c.tangent_names = {"angle", "rate"};
      }};
  for (const auto& change : changes) {
    SolutionClaims other = answer.claims;
    change(other);
    EXPECT_FALSE(is_taken_over(other)) << &change - changes;
  }
}

}  // namespace
}  // namespace conddp
