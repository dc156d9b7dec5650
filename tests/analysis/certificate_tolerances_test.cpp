// Permitted error of each figure, using numbers that make rounding small or large at one place at a
// time.
#include <optional>

#include <gtest/gtest.h>

#include "analysis/certificate/certificate.hpp"
#include "analysis/certificate/check.hpp"
#include "support/small_problems.hpp"

namespace conddp {
namespace {

constexpr int kEntries = 2, kKnots = 2;

/// Two steps x⁺ = a (x + u) in two coordinates with cost Σ ½ q_k ‖x_k − g_k‖² + ½ r_k ‖u_k − w_k‖²
/// and rows x_k − c_k ≤ 0 at every node. Values default to 0, factors and weights to 1.
struct PlainAnswer {
  double dt[kKnots] = {1, 1};
  double a[kKnots] = {1, 1}, r[kKnots] = {1, 1}, q[kKnots + 1] = {1, 1, 1};
  Eigen::Vector2d x[kKnots + 1], u[kKnots], g[kKnots + 1], w[kKnots], c[kKnots + 1];
  Eigen::Vector2d costate[kKnots + 1], multiplier[kKnots + 1], lower_z[kKnots], upper_z[kKnots];

  PlainAnswer() {
    for (auto* vectors : {x, g, c, costate, multiplier})
      for (int k = 0; k <= kKnots; ++k) vectors[k].setZero();
    for (auto* vectors : {u, w, lower_z, upper_z})
      for (int k = 0; k < kKnots; ++k) vectors[k].setZero();
  }

  ShootingProblem problem() const {
    std::vector<Phase> phases;
    for (int k = 0; k < kKnots; ++k) {
      const auto model = model_of(k);
      model->add_cost("effort", control_residual(kEntries, kEntries), {});
      phases.push_back({.name = k == 0 ? "first" : "second",
                        .model = model,
                        .dt = {dt[k]},
                        .cost_scale = {1},
                        .parameters = parameters_of(*model, k)});
    }
    const auto end = model_of(kKnots);
    return {{x[0][0], x[0][1]},
            std::move(phases),
            {.name = "end",
             .model = end,
             .dt = {0},
             .cost_scale = {1},
             .parameters = parameters_of(*end, kKnots)}};
  }

  /// Claims of an honest answer that does not claim convergence.
  SolutionClaims claims(const ShootingProblem& of) const {
    SolutionClaims claims(of);
    claims.times = of.times();
    claims.status = "max_iterations";
    claims.gap = claims.stationarity = claims.constraint = claims.complementarity = 0;
    claims.multipliers.resize(kEntries * (kKnots + 1));
    double state = 0, effort = 0, terminal = 0;
    for (int k = 0; k <= kKnots; ++k) {
      claims.trajectory.x(k) = x[k];
      claims.costates.col(k) = costate[k];
      claims.multipliers.segment<kEntries>(kEntries * k) = multiplier[k];
      (k < kKnots ? state : terminal) += 0.5 * q[k] * (x[k] - g[k]).squaredNorm();
      claims.state_gradient.col(k) = q[k] * (x[k] - g[k]) - costate[k] + multiplier[k];
      const Eigen::Vector2d value = x[k] - c[k];
      claims.constraint = std::max(claims.constraint, value.maxCoeff());
      claims.complementarity =
          std::max(claims.complementarity,
                   multiplier[k].cwiseProduct(value.cwiseMin(0)).lpNorm<Eigen::Infinity>());
      if (k == kKnots) break;
      claims.trajectory.u(k) = u[k];
      claims.lower_multipliers[k] = lower_z[k];
      claims.upper_multipliers[k] = upper_z[k];
      effort += 0.5 * r[k] * (u[k] - w[k]).squaredNorm();
      claims.state_gradient.col(k) += a[k] * costate[k + 1];
      const Eigen::Vector2d slope =
          r[k] * (u[k] - w[k]) + a[k] * costate[k + 1] - lower_z[k] + upper_z[k];
      claims.stationarity = std::max(claims.stationarity, slope.lpNorm<Eigen::Infinity>());
      claims.gap =
          std::max(claims.gap, (a[k] * (x[k] + u[k]) - x[k + 1]).lpNorm<Eigen::Infinity>());
    }
    claims.cost_by_name = {{"state", state}, {"effort", effort}, {"terminal/state", terminal}};
    claims.cost = state + effort + terminal;
    // A negative tolerance: no figures can imply convergence.
    claims.tolerances.stationarity = -1;
    return claims;
  }

  /// Names of the checks that fail after `change` modifies honest claims.
  template <class Change>
  std::string failures(const Change& change) const {
    const ShootingProblem of = problem();
    SolutionClaims changed = claims(of);
    change(changed);
    std::string names;
    for (const Check& check : certify(of, changed).checks)
      if (!check.holds) names += "[" + check.name + "]";
    return names;
  }
  std::string failures() const {
    return failures([](SolutionClaims&) {});
  }
  std::string failures_off(double SolutionClaims::*figure, double off) const {
    return failures([&](SolutionClaims& claims) { claims.*figure += off; });
  }

 private:
  std::shared_ptr<KnotModel> model_of(int k) const {
    const double factor = k < kKnots ? a[k] : 1;
    const Eigen::MatrixXd matrix = factor * Eigen::MatrixXd::Identity(kEntries, kEntries);
    auto model =
        std::make_shared<KnotModel>(linear_system(matrix, matrix, Eigen::VectorXd::Zero(kEntries)),
                                    k < kKnots ? Integrator::discrete : Integrator::none);
    model->add_cost("state", state_residual(model->manifold()), {});
    model->add_constraint(
        make_constraint("rows", state_residual(model->manifold()), ConstraintKind::bounds));
    return model;
  }
  std::vector<double> parameters_of(const KnotModel& model, int k) const {
    std::vector<double> numbers(model.parameter_count(), 0.0);
    const auto put = [&](int at, const Eigen::Vector2d& values) {
      numbers[at] = values[0];
      numbers[at + 1] = values[1];
    };
    for (const CostTerm& term : model.costs()) {
      const bool of_state = term.name == "state";
      put(term.parameters, of_state ? g[k] : w[k]);
      numbers[term.weight] = of_state ? q[k] : r[k];
    }
    const ConstraintTerm& rows = model.constraints().front();
    put(rows.parameters, c[k]);
    put(rows.lower(), Eigen::Vector2d::Constant(-testing::kFree));
    numbers[rows.active()] = 1;
    return numbers;
  }
};

TEST(CertificateTolerances, HonestAnswerHoldsForAnyNumbers) {
  PlainAnswer answer;
  EXPECT_EQ(answer.failures(), "");
  for (int k = 0; k <= kKnots; ++k) {
    answer.x[k] << 0.5 + k, -1.25;
    answer.g[k] << -0.5, 2.0 * k;
    answer.c[k] << 1, k;
    answer.costate[k] << 3 - k, 0.25;
    answer.multiplier[k] << 0.75, k;
    answer.q[k] = 1 + k;
    if (k == kKnots) break;
    answer.u[k] << 2, -0.5 * k;
    answer.w[k] << k, 4;
    answer.r[k] = 3 - k;
    answer.a[k] = 2 + k;
  }
  EXPECT_EQ(answer.failures(), "");
}

// At 0, where relative rounding changes nothing.
TEST(CertificateTolerances, AreAbsoluteNearZero) {
  const PlainAnswer answer;
  for (const double sign : {1.0, -1.0}) {
    EXPECT_EQ(answer.failures_off(&SolutionClaims::gap, sign * 0.9e-11), "");
    EXPECT_EQ(answer.failures_off(&SolutionClaims::gap, sign * 1.1e-11), "[gap]");
    EXPECT_EQ(answer.failures_off(&SolutionClaims::stationarity, sign * 0.9e-11), "");
    EXPECT_EQ(answer.failures_off(&SolutionClaims::stationarity, sign * 1.1e-11), "[stationarity]");
    EXPECT_EQ(answer.failures_off(&SolutionClaims::constraint, sign * 0.9e-10), "");
    EXPECT_EQ(answer.failures_off(&SolutionClaims::constraint, sign * 1.1e-10),
              "[constraint violation]");
    EXPECT_EQ(answer.failures_off(&SolutionClaims::cost, sign * 0.9e-16), "");
    EXPECT_EQ(answer.failures_off(&SolutionClaims::cost, sign * 1.1e-16), "[cost]");
  }
  EXPECT_EQ(answer.failures_off(&SolutionClaims::complementarity, 1e-30), "[complementarity]");
}

// Times match the file almost to the last bit; an error equal to the tolerance is accepted.
TEST(CertificateTolerances, TimeToleranceGrowsWithTheHorizon) {
  PlainAnswer answer;
  const auto with_start_at = [&](double time) {
    return answer.failures([&](SolutionClaims& claims) { claims.times[0] = time; });
  };
  answer.dt[0] = answer.dt[1] = 0.25;
  EXPECT_EQ(with_start_at(1e-12), "");
  EXPECT_EQ(with_start_at(1.1e-12), "[times]");
  answer.dt[0] = answer.dt[1] = 500;
  EXPECT_EQ(with_start_at(-0.9e-9), "");
  EXPECT_EQ(with_start_at(-1.1e-9), "[times]");
}

TEST(CertificateTolerances, InitialStateToleranceGrowsWithTheState) {
  for (const double start : {0.0, 1e4}) {
    const double tolerance = std::max(1e-12, 1e-12 * start);
    for (const int entry : {0, 1})
      for (const double share : {0.8, 1.2}) {
        PlainAnswer answer;
        answer.x[0][1 - entry] = start;
        const ShootingProblem problem = answer.problem();
        answer.x[0][entry] = share * tolerance;
        SolutionClaims claims = answer.claims(problem);
        bool holds = true;
        for (const Check& check : certify(problem, claims).checks)
          if (check.name == "initial state") holds = check.holds;
        EXPECT_EQ(holds, share < 1) << start << ' ' << entry;
      }
  }
}

// States reached by the steps contribute like those of the answer. Rounding of states of size 100
// may add as much again.
TEST(CertificateTolerances, GapToleranceGrowsWithTheLargestState) {
  for (const int k : {0, 1}) {
    PlainAnswer at_state, at_next;
    at_state.x[k][1] = 100;
    at_state.g[k] = at_state.c[k] = at_state.x[k];
    at_next.u[k].setConstant(100);
    at_next.w[k] = at_next.u[k];
    for (const PlainAnswer* answer : {&at_state, &at_next}) {
      EXPECT_EQ(answer->failures_off(&SolutionClaims::gap, 0.9e-9), "") << k;
      EXPECT_EQ(answer->failures_off(&SolutionClaims::gap, 2.1e-9), "[gap]") << k;
    }
  }
}

// Costs that cancel round like costs that do not.
TEST(CertificateTolerances, CostToleranceGrowsWithItsTerms) {
  PlainAnswer answer;
  answer.g[0] << 2, 0;       // costs 2
  answer.w[1] << 0, 4;       // costs 8
  answer.g[kKnots] << 4, 4;  // costs −16, and the sum −6
  answer.q[kKnots] = -1;
  EXPECT_EQ(answer.failures(), "");
  constexpr double kSize = 2 + 8 + 16;
  for (const double sign : {1.0, -1.0}) {
    EXPECT_EQ(answer.failures_off(&SolutionClaims::cost, sign * 0.9e-10 * kSize), "");
    EXPECT_EQ(answer.failures_off(&SolutionClaims::cost, sign * 1.1e-10 * kSize), "[cost]");
  }
  for (int name = 0; name < 3; ++name) {
    const auto with_off = [&](double off) {
      return answer.failures([&](SolutionClaims& c) { c.cost_by_name[name].second += off; });
    };
    EXPECT_EQ(with_off(-0.9e-10 * kSize), "") << name;
    const char* const failing[] = {"[cost state]", "[cost effort]", "[cost terminal/state]"};
    EXPECT_EQ(with_off(-1.1e-10 * kSize), failing[name]);
  }
}

// A gradient near 0 with terms of 10⁶ from costs, costates, or bound multipliers.
TEST(CertificateTolerances, StationarityToleranceGrowsWithGradientTerms) {
  constexpr double kLarge = 1e6;
  for (const int k : {0, 1})
    for (const int entry : {0, 1}) {
      PlainAnswer by_bounds, by_costates, by_costs;
      by_bounds.lower_z[k][entry] = by_bounds.upper_z[k][entry] = kLarge;
      by_costates.costate[k + 1][entry] = kLarge;
      by_costates.w[k][entry] = kLarge;
      by_costs.w[k][entry] = kLarge;
      by_costs.lower_z[k][entry] = -kLarge;
      const auto with_off = [&](const PlainAnswer& answer, double off) {
        return answer.failures([&](SolutionClaims& c) {
          c.stationarity += off;
          c.complementarity = testing::kFree;  // no bounds
        });
      };
      // 10⁻¹¹ of both terms, plus 10⁻¹² of the largest term other than a bound multiplier.
      const std::string found = with_off(by_bounds, 1.9e-5);
      EXPECT_EQ(found.find("[stationarity]"), std::string::npos) << found;
      EXPECT_NE(with_off(by_bounds, 2.1e-5).find("[stationarity]"), std::string::npos);
      EXPECT_EQ(with_off(by_costates, 2.1e-5).find("[stationarity]"), std::string::npos);
      EXPECT_NE(with_off(by_costates, 2.3e-5).find("[stationarity]"), std::string::npos);
      EXPECT_EQ(with_off(by_costs, 2.05e-5).find("[stationarity]"), std::string::npos);
      EXPECT_NE(with_off(by_costs, 2.15e-5).find("[stationarity]"), std::string::npos);
    }
}

// The largest entry of a node determines the rounding of the other entries.
TEST(CertificateTolerances, CostateToleranceGrowsWithItsTermsAndNode) {
  constexpr double kLarge = 1e6;
  for (int k = 0; k <= kKnots; ++k)
    for (const int entry : {0, 1}) {
      PlainAnswer answer;
      answer.g[k][entry] = kLarge;
      const auto with_off = [&](int at, double off) {
        return answer.failures([&](SolutionClaims& c) { c.state_gradient(at, k) += off; });
      };
      // The size is 10⁶ for both the cost and the claim.
      EXPECT_EQ(with_off(entry, 2.1e-5), "") << k << ' ' << entry;
      EXPECT_EQ(with_off(entry, 2.3e-5), "[co-states]") << k << ' ' << entry;
      EXPECT_EQ(with_off(1 - entry, 1.9e-6), "") << k << ' ' << entry;
      EXPECT_EQ(with_off(1 - entry, 2.1e-6), "[co-states]") << k << ' ' << entry;
    }
}

// A row of 10³ at its bound with a multiplier of 10⁴.
TEST(CertificateTolerances, ConstraintToleranceGrowsWithValuesAndMultipliers) {
  for (int k = 0; k <= kKnots; ++k)
    for (const int entry : {0, 1}) {
      PlainAnswer answer;
      answer.c[k][entry] = -1e3;
      const auto fails = [&](double off) {
        return answer.failures_off(&SolutionClaims::constraint, off);
      };
      EXPECT_EQ(fails(0.9e-7), "") << k << ' ' << entry;
      EXPECT_EQ(fails(1.1e-7), "[constraint violation]") << k << ' ' << entry;
      PlainAnswer pushed;
      pushed.multiplier[k][entry] = 1e4;
      const auto complements = [&](double off) {
        return pushed.failures_off(&SolutionClaims::complementarity, off);
      };
      EXPECT_EQ(complements(0.9e-6), "") << k << ' ' << entry;
      EXPECT_EQ(complements(1.1e-6), "[complementarity]") << k << ' ' << entry;
    }
}

// A factor of 10⁶ amplifies a rounding error of 10⁻¹³ to 10⁻⁷.
TEST(CertificateTolerances, ContainRoundingOfTheAnswersNumbers) {
  constexpr double kFactor = 1e6, kOff = 1e-8;
  for (int k = 0; k <= kKnots; ++k)
    for (const int entry : {0, 1}) {
      SCOPED_TRACE(std::to_string(k) + ' ' + std::to_string(entry));
      PlainAnswer state;
      state.q[k] = kFactor;
      state.x[k][entry] = state.g[k][entry] = state.c[k][entry] = 1;
      const auto with_state_gradient = [&](const PlainAnswer& answer) {
        return answer.failures([&](SolutionClaims& c) { c.state_gradient(entry, k) += kOff; });
      };
      EXPECT_EQ(with_state_gradient(state), "");
      state.q[k] = 1;
      EXPECT_EQ(with_state_gradient(state), "[co-states]");

      PlainAnswer row;
      row.x[k][entry] = row.g[k][entry] = row.c[k][entry] = kFactor;
      EXPECT_EQ(row.failures_off(&SolutionClaims::constraint, kOff), "");
      row.x[k][entry] = row.g[k][entry] = row.c[k][entry] = 1;
      EXPECT_EQ(row.failures_off(&SolutionClaims::constraint, kOff), "[constraint violation]");

      PlainAnswer cost;
      cost.x[k][entry] = cost.c[k][entry] = kFactor;
      cost.g[k][entry] = kFactor + 1;
      EXPECT_EQ(cost.failures_off(&SolutionClaims::cost, kOff), "");
      cost.x[k][entry] = cost.c[k][entry] = 1;
      cost.g[k][entry] = 2;
      EXPECT_EQ(cost.failures_off(&SolutionClaims::cost, kOff), "[cost]");
      if (k == kKnots) continue;

      PlainAnswer control;
      control.r[k] = kFactor;
      control.u[k][entry] = control.w[k][entry] = 1;
      const auto with_stationarity = [&] {
        return control.failures_off(&SolutionClaims::stationarity, kOff);
      };
      EXPECT_EQ(with_stationarity(), "");
      control.r[k] = 1;
      EXPECT_EQ(with_stationarity(), "[stationarity]");

      PlainAnswer gap;
      gap.a[k] = kFactor;
      gap.x[k][entry] = gap.g[k][entry] = gap.c[k][entry] = 1;
      gap.u[k][entry] = gap.w[k][entry] = -1;
      EXPECT_EQ(gap.failures_off(&SolutionClaims::gap, kOff), "");
      gap.a[k] = 1;
      EXPECT_EQ(gap.failures_off(&SolutionClaims::gap, kOff), "[gap]");
    }
}

// Rounding of a row contributes to complementarity in proportion to the largest multiplier.
TEST(CertificateTolerances, ComplementarityToleranceIncludesRoundingOfRows) {
  PlainAnswer answer;
  answer.x[1][0] = answer.g[1][0] = answer.c[1][0] = 1e6;
  answer.multiplier[2][1] = 10;
  EXPECT_EQ(answer.failures_off(&SolutionClaims::complementarity, 1e-8), "");
  answer.x[1][0] = answer.g[1][0] = answer.c[1][0] = 0;
  EXPECT_EQ(answer.failures_off(&SolutionClaims::complementarity, 1e-8), "[complementarity]");
}

/// The check with this name, or a default check.
Check check_named(const Certificate& certificate, const std::string& name) {
  for (const Check& check : certificate.checks)
    if (check.name == name) return check;
  ADD_FAILURE() << "there is no check of " << name;
  return {};
}

TEST(CertificatePlaces, NameTheWorstEntries) {
  for (const int k : {0, 1})
    for (const int entry : {0, 1}) {
      PlainAnswer answer;
      answer.w[k][entry] = 1;
      answer.w[1 - k][1 - entry] = 0.5;
      answer.x[k + 1][entry] = 3;
      answer.x[2 - k][1 - entry] = 2;
      const ShootingProblem problem = answer.problem();
      SolutionClaims claims = answer.claims(problem);
      claims.tangent_names = {"left", "right"};
      claims.gap = claims.stationarity = claims.constraint = 7;
      claims.state_gradient(entry, k + 1) += 1;
      claims.times[k] += 1;
      const Certificate found = certify(problem, claims);
      const std::string name = entry == 0 ? "left" : "right";
      const std::string here = k == 0 ? "knot 0 (phase 'first')" : "knot 1 (phase 'second')";
      const std::string next = k == 0 ? "knot 1 (phase 'second')" : "knot 2 (the last node)";
      EXPECT_EQ(check_named(found, "times").place, here);
      EXPECT_EQ(check_named(found, "times").claimed, k + 1);
      EXPECT_EQ(check_named(found, "times").found, k);
      EXPECT_EQ(check_named(found, "stationarity").place,
                here + ", " + control_name(problem, k, entry));
      EXPECT_EQ(check_named(found, "constraint violation").place, next + ", constraint 'rows'");
      EXPECT_EQ(check_named(found, "constraint violation").found, 3);
      EXPECT_EQ(check_named(found, "gap").place, here + ", " + name);
      EXPECT_EQ(check_named(found, "co-states").place, next + ", " + name);
      EXPECT_EQ(check_named(found, "co-states").claimed, 3 + 1);
      EXPECT_EQ(check_named(found, "co-states").found, 3);
    }
}

/// Judges an answer that claims convergence under the default tolerances.
struct Verdict {
  explicit Verdict(const PlainAnswer& answer) : problem(answer.problem()) {
    claims.emplace(answer.claims(problem));
    claims->tolerances = {};
    claims->converged = true;
    claims->status = "converged";
  }
  /// Faults of the status; all other checks must hold.
  std::string wrong() {
    const Certificate found = certify(problem, *claims);
    in_doubt = found.optimality_in_doubt;
    for (const Check& check : found.checks)
      EXPECT_TRUE(check.holds || check.name == kStatusCheck) << check.name;
    const Check status = check_named(found, kStatusCheck);
    EXPECT_EQ(status.holds, status.message.empty());
    return status.message;
  }

  ShootingProblem problem;
  std::optional<SolutionClaims> claims;
  bool in_doubt = false;
};

/// A motion of one unit; small gradients are negligible against its cost.
PlainAnswer moving() {
  PlainAnswer answer;
  answer.u[0][0] = answer.w[0][0] = 1;
  for (const int k : {1, 2}) answer.x[k][0] = answer.g[k][0] = answer.c[k][0] = 1;
  answer.g[0][0] = 10;
  answer.costate[0][0] = -10;
  return answer;
}

TEST(CertificateStatus, ConvergedAllowsForRoundingOfFigures) {
  EXPECT_EQ(Verdict(PlainAnswer()).wrong(), "");
  PlainAnswer slope = moving();
  slope.w[1][1] = 1e-6 + 0.5e-11;
  Verdict of_slope(slope);
  of_slope.claims->stationarity = 1e-6;
  EXPECT_EQ(of_slope.wrong(), "");
  PlainAnswer open = moving();
  open.x[1][1] = open.x[2][1] = 1e-9 + 0.5e-11;
  for (const int k : {1, 2}) open.g[k] = open.c[k] = open.x[k];
  Verdict of_gap(open);
  of_gap.claims->gap = 1e-9;
  EXPECT_EQ(of_gap.wrong(), "");
}

// A terminal costate that balances the gradient but follows from no cost.
TEST(CertificateStatus, ConvergedNeedsAReducedGradientUnderTenTolerances) {
  const auto with_gradient = [](double gradient) {
    PlainAnswer answer = moving();
    answer.w[1][1] = answer.costate[2][1] = gradient;
    Verdict verdict(answer);
    const std::string wrong = verdict.wrong();
    EXPECT_EQ(verdict.in_doubt, !wrong.empty());
    return wrong;
  };
  EXPECT_EQ(with_gradient(0.9e-5), "");
  EXPECT_EQ(with_gradient(1.1e-5),
            "'converged', but the reduced gradient at knot 1 (phase 'second'), u/1 is 1.1e-05, "
            "tolerance 1e-05");
  EXPECT_EQ(with_gradient(2),
            "'converged', but the reduced gradient at knot 1 (phase 'second'), u/1 is 2, tolerance "
            "1e-05; the relative distance of the co-states from those with other gains and without "
            "gains is 0.2, tolerance 0.001; the share of the cost that a Newton step would gain or "
            "repair is 0.067, tolerance 1e-05");
}

// States do not propagate, and no gradient contains the costate.
TEST(CertificateStatus, ConvergedNeedsCostatesUnderAThousandTolerances) {
  for (const int k : {0, 1})
    for (const double costate : {0.9e-3, 1.1e-3, -1.1e-3}) {
      PlainAnswer answer;
      answer.a[k] = 0;
      answer.costate[k + 1][1] = costate;
      if (k == 0) answer.g[1][1] = -costate;
      const std::string wrong = Verdict(answer).wrong();
      EXPECT_EQ(wrong.find("co-states") != std::string::npos, k == 1 && std::abs(costate) > 1e-3)
          << wrong;
    }
}

TEST(CertificateStatus, ConvergedNeedsAMotionWithinItsConstraints) {
  PlainAnswer answer;
  answer.c[2][1] = -1e-6 - 0.5e-10;
  Verdict verdict(answer);
  verdict.claims->constraint = 1e-6;
  EXPECT_TRUE(verdict.wrong().starts_with(
      "'converged', but constraint violation is 1e-06, tolerance 1e-06; the share of the cost that "
      "a Newton step would gain or repair is"))
      << verdict.wrong();
  EXPECT_FALSE(verdict.in_doubt) << "it is no question of optimality";
}

TEST(CertificateStatus, ReportsWhetherAllFiguresMeetTolerances) {
  Verdict verdict{PlainAnswer()};
  verdict.claims->converged = false;
  verdict.claims->status = "stalled";
  EXPECT_EQ(verdict.wrong(), "'stalled', but all claimed residuals are under their tolerances");
  for (double SolverOptions::Tolerances::*tolerance :
       {&SolverOptions::Tolerances::stationarity, &SolverOptions::Tolerances::gap,
        &SolverOptions::Tolerances::constraint, &SolverOptions::Tolerances::complementarity}) {
    Verdict above{PlainAnswer()};
    above.claims->tolerances.*tolerance = -1e-3;
    EXPECT_EQ(above.wrong(), "'converged', but a claimed residual is above its tolerance");
    above.claims->converged = false;
    above.claims->status = "stalled";
    EXPECT_EQ(above.wrong(), "");
  }
}

/// A settled cost with stationarity above its tolerance.
struct SettledVerdict : Verdict {
  explicit SettledVerdict(const PlainAnswer& answer) : Verdict(answer) {
    claims->converged = false;
    claims->status = "cost_settled";
    claims->tolerances.stationarity = -1;
    claims->tolerances.cost_decrease = 1e-4;
  }
};

// Both claimed and computed figures must be within tolerance.
TEST(CertificateStatus, CostSettledNeedsAFeasibleMotion) {
  const std::string above =
      "'cost_settled', but a gap, a violation or the complementarity is above its tolerance";
  EXPECT_EQ(SettledVerdict(PlainAnswer()).wrong(), "");
  PlainAnswer open, outside, inside;
  open.x[1][0] = open.x[2][0] = 1e-9 + 0.5e-11;
  for (const int k : {1, 2}) open.g[k] = open.c[k] = open.x[k];
  outside.c[1][0] = -1e-6 - 0.5e-10;
  inside.c[1][0] = 1e-6 + 0.5e-10;
  inside.multiplier[1][0] = 1;
  struct Case {
    const PlainAnswer* answer;
    double SolutionClaims::*figure;
    double claimed;
    bool holds;
  };
  for (const Case& c : {Case{&open, &SolutionClaims::gap, 1e-9, true},
                        {&open, &SolutionClaims::gap, 1e-9 + 0.4e-11, false},
                        {&outside, &SolutionClaims::constraint, 1e-6, false},
                        {&inside, &SolutionClaims::complementarity, 1e-6, false}}) {
    SettledVerdict verdict(*c.answer);
    (*verdict.claims).*c.figure = c.claimed;
    EXPECT_EQ(verdict.wrong(), c.holds ? "" : above) << c.claimed;
  }
  outside.c[1][0] = -1e-6;
  inside.c[1][0] = 1e-6;
  const auto with_more = [](const PlainAnswer& answer, double SolutionClaims::*figure,
                            double more) {
    SettledVerdict verdict(answer);
    (*verdict.claims).*figure += more;
    return verdict.wrong();
  };
  EXPECT_EQ(with_more(outside, &SolutionClaims::constraint, 0), "");
  EXPECT_EQ(with_more(outside, &SolutionClaims::constraint, 0.5e-10), above);
  EXPECT_EQ(with_more(inside, &SolutionClaims::complementarity, 0), "");
  EXPECT_EQ(with_more(inside, &SolutionClaims::complementarity, 0.5e-10), above);
}

TEST(Certificate, IsComputableIfFailedFiguresAreFinite) {
  const double infinity = testing::kFree;
  const auto computable = [](bool holds, double found, double tolerance) {
    Certificate certificate;
    certificate.checks = {{.name = "gap"},
                          {.name = "cost", .holds = holds, .found = found, .tolerance = tolerance}};
    EXPECT_EQ(certificate.holds(), holds);
    EXPECT_EQ(certificate.failures(), holds ? 0 : 1);
    return certificate.computable();
  };
  EXPECT_TRUE(computable(true, infinity, 1));
  EXPECT_TRUE(computable(false, 5, 1));
  EXPECT_FALSE(computable(false, infinity, 1));
  EXPECT_FALSE(computable(false, Check::kNone, 1));
  EXPECT_TRUE(computable(false, Check::kNone, Check::kNone)) << "it is no check of a figure";
}

}  // namespace
}  // namespace conddp
