// Thresholds between diagnosis patterns of a log.
#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "analysis/findings/diagnosis.hpp"
#include "support/small_problems.hpp"

namespace conddp {
namespace {

struct Ending {
  SolveStatus status = SolveStatus::max_iterations;
  int failed_knot = -1;
  std::string_view failed_quantity = {};
};

/// Diagnosis of a log stalled at full steps, modified row by row.
Diagnosis diagnosis_of_log(int rows, const std::function<void(int, IterationRecord&)>& change,
                           const Ending& ending = {},
                           const ShootingProblem& problem = testing::pendulum_swing_up()) {
  SolveResult result(problem);
  result.status = ending.status;
  result.failed_knot = ending.failed_knot;
  result.failed_quantity = ending.failed_quantity;
  for (int i = 0; i < rows; ++i) {
    IterationRecord row;
    row.iteration = i;
    row.step = 1;
    row.stationarity = 1;
    row.stationarity_knot = 7;
    row.gap_knot = 5;
    row.constraint_knot = 3;
    change(i, row);
    result.log.push_back(row);
  }
  const IterationRecord& last = result.log.back();
  result.residuals.stationarity = last.stationarity;
  result.residuals.gap = last.gap;
  result.residuals.constraint = last.constraint;
  result.residuals.stationarity_knot = last.stationarity_knot;
  result.residuals.gap_knot = last.gap_knot;
  return diagnose(problem, result, {});
}

TEST(DiagnosisPatterns, NonFiniteNumberIsGrowth) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (double IterationRecord::*number :
       {&IterationRecord::cost, &IterationRecord::stationarity, &IterationRecord::gap}) {
    const Diagnosis d =
        diagnosis_of_log(6, [&](int i, IterationRecord& r) { r.*number = i == 5 ? kNan : 0.5; });
    EXPECT_EQ(d.pattern, DiagnosisPattern::growth);
  }
}

TEST(DiagnosisPatterns, FiniteGrowingIteratesHaveNoPoles) {
  SolveResult result(testing::pendulum_swing_up());
  result.status = SolveStatus::diverged;
  result.iterations = 5;
  result.cost = -3e8;
  const Diagnosis d = diagnose(testing::pendulum_swing_up(), result, {});
  EXPECT_EQ(d.pattern, DiagnosisPattern::growth);
  EXPECT_EQ(d.message, "the iterates grow without bound");
  EXPECT_EQ(d.remedy.find("smooth"), std::string::npos) << d.remedy;
}

TEST(DiagnosisPatterns, HalvingWithinTheWindowIsProgress) {
  const auto gap_to = [](double last) {
    return diagnosis_of_log(11, [=](int i, IterationRecord& r) {
      r.stationarity = std::pow(0.1, i);
      r.gap = i == 0 ? 1 : i == 10 ? last : 0.01;
    });
  };
  EXPECT_EQ(gap_to(0.51).pattern, DiagnosisPattern::open_gaps);
  EXPECT_EQ(gap_to(0.49).pattern, DiagnosisPattern::unfinished);
  // The window has ten steps: the row before it counts, older rows do not.
  const auto later = [](int best) {
    return diagnosis_of_log(12, [=](int i, IterationRecord& r) {
      r.stationarity = std::pow(0.1, i);
      r.gap = i == best ? 1 : 0.1;
    });
  };
  EXPECT_EQ(later(1).pattern, DiagnosisPattern::unfinished);
  EXPECT_EQ(later(0).pattern, DiagnosisPattern::open_gaps);
}

TEST(DiagnosisPatterns, FourStepsAreNeeded) {
  const auto short_steps = [](int rows) {
    return diagnosis_of_log(rows, [](int, IterationRecord& r) { r.step = 0.1; });
  };
  EXPECT_EQ(short_steps(5).pattern, DiagnosisPattern::plateau);
  EXPECT_EQ(short_steps(4).pattern, DiagnosisPattern::unfinished);
}

TEST(DiagnosisPatterns, PlateauNeedsMedianStepOfAQuarter) {
  const auto steps = [](double step) {
    return diagnosis_of_log(11, [=](int i, IterationRecord& r) {
      r.step = i == 0 || i > 8 ? 1 : i < 4 ? step / 2 : step;
    });
  };
  EXPECT_EQ(steps(0.25).pattern, DiagnosisPattern::plateau);
  EXPECT_NE(steps(0.25).message.find("steps of 0.25"), std::string::npos) << steps(0.25).message;
  EXPECT_EQ(steps(0.26).pattern, DiagnosisPattern::unfinished);
}

// Short steps that make progress, or that have nothing left to gain.
TEST(DiagnosisPatterns, PlateauStallsAboveItsTolerance) {
  const auto from_to = [](double first, double last) {
    return diagnosis_of_log(6, [=](int i, IterationRecord& r) {
      r.step = 0.1;
      r.stationarity = i == 0 ? first : last;
    });
  };
  EXPECT_EQ(from_to(1, 0.51).pattern, DiagnosisPattern::plateau);
  EXPECT_EQ(from_to(1, 0.49).pattern, DiagnosisPattern::unfinished);
  const double tolerance = SolverOptions{}.tolerances.stationarity;
  EXPECT_EQ(from_to(tolerance, 1.01 * tolerance).pattern, DiagnosisPattern::plateau);
  EXPECT_EQ(from_to(tolerance, 0.99 * tolerance).pattern, DiagnosisPattern::unfinished);
}

TEST(DiagnosisPatterns, FarFromFeasibleTheViolationDecides) {
  const double tolerance = SolverOptions{}.tolerances.constraint;
  const auto ends_at = [](int rows, double step, double first, double last) {
    return diagnosis_of_log(rows, [=](int i, IterationRecord& r) {
      r.step = i % 2 == 0 ? step : 0.9 * step;
      r.constraint = i == rows - 1 ? last : first;
    });
  };
  const auto stalled = [&](double violation) { return ends_at(11, 0.1, violation, violation); };
  EXPECT_EQ(stalled(1001 * tolerance).pattern, DiagnosisPattern::undecided);
  EXPECT_NE(stalled(1).message.find("the violation stalled: 1.0e+00"), std::string::npos)
      << stalled(1).message;
  EXPECT_EQ(stalled(999 * tolerance).pattern, DiagnosisPattern::plateau);
  EXPECT_EQ(ends_at(11, 0.1, 1, 0.49).pattern, DiagnosisPattern::plateau) << "it falls";
  // A solve that continued with long steps.
  EXPECT_EQ(ends_at(300, 0.9, 1, 1).pattern, DiagnosisPattern::undecided);
  EXPECT_EQ(ends_at(11, 0.9, 1, 1).pattern, DiagnosisPattern::unfinished) << "too early to say";
}

TEST(DiagnosisPatterns, RegularizedPlateauIsRegularizedInEveryStep) {
  const auto regularised = [](int without) {
    return diagnosis_of_log(
        11, [=](int i, IterationRecord& r) { r.regularization = i == without ? 0 : 10; });
  };
  EXPECT_EQ(regularised(0).pattern, DiagnosisPattern::plateau);  // before the window
  EXPECT_EQ(regularised(4).pattern, DiagnosisPattern::unfinished);
}

TEST(DiagnosisPatterns, SlowFeasibilityHalvesLessThanOnceAStep) {
  const auto falling = [](double factor) {
    return diagnosis_of_log(6, [=](int i, IterationRecord& r) {
      r.stationarity = std::pow(0.1, i);
      r.constraint = std::pow(factor, i);
    });
  };
  EXPECT_EQ(falling(0.51).pattern, DiagnosisPattern::slow_feasibility);
  EXPECT_EQ(falling(0.51).knot, 3);
  EXPECT_EQ(falling(0.49).pattern, DiagnosisPattern::unfinished);
}

/// A cost that is linear in the final angle.
ShootingProblem with_linear_cost() {
  const ShootingProblem pendulum = testing::pendulum_swing_up();
  const std::shared_ptr<const System>& system = pendulum.phases()[0].model->shared_system();
  auto model = std::make_shared<KnotModel>(system, Integrator::none);
  model->add_cost("angle", coordinate_residual(system->manifold(), {0}),
                  {.kind = ActivationKind::linear});
  return {pendulum.initial_state(),
          pendulum.phases(),
          {.name = "end", .model = model, .dt = {0}, .cost_scale = {1}, .parameters = {0, -1}}};
}

TEST(DiagnosisPatterns, FallingLinearCostOutrunsThePenalty) {
  const auto away = [](double violation, double slope, const ShootingProblem& problem) {
    return diagnosis_of_log(
        12,
        [=](int i, IterationRecord& r) {
          r.cost = slope * i;
          r.constraint = violation;
        },
        {}, problem);
  };
  const ShootingProblem linear = with_linear_cost();
  const Diagnosis d = away(0.5, -10, linear);
  EXPECT_EQ(d.pattern, DiagnosisPattern::outrun_penalty);
  EXPECT_EQ(d.knot, 3);
  EXPECT_NE(d.message.find("cost -110, violation 5.0e-01 at knot 3"), std::string::npos)
      << d.message;
  EXPECT_NE(d.remedy.find("--solver ipopt"), std::string::npos) << d.remedy;
  EXPECT_EQ(away(0.5, 10, linear).pattern, DiagnosisPattern::slow_feasibility);
  EXPECT_EQ(away(1e-5, -10, linear).pattern, DiagnosisPattern::slow_feasibility);
  EXPECT_EQ(away(0.5, -10, testing::pendulum_swing_up()).pattern,
            DiagnosisPattern::slow_feasibility);
}

TEST(DiagnosisPatterns, LargeViolationIsNotBlamedOnRounding) {
  const auto ended = [](double violation, const ShootingProblem& problem) {
    return diagnosis_of_log(
               3, [=](int, IterationRecord& r) { r.constraint = violation; },
               {.status = SolveStatus::line_search_failed, .failed_quantity = kRoundedCost},
               problem)
        .pattern;
  };
  const ShootingProblem squares = testing::pendulum_swing_up();
  EXPECT_EQ(ended(1e-5, squares), DiagnosisPattern::rounding_floor);
  EXPECT_EQ(ended(0.57, squares), DiagnosisPattern::no_descent);
  EXPECT_EQ(ended(0.57, with_linear_cost()), DiagnosisPattern::outrun_penalty);
}

TEST(DiagnosisPatterns, RestorationFarFromFeasibleIsInconclusive) {
  const auto ended = [](SolveStatus status, double violation, int restoration) {
    return diagnosis_of_log(6,
                            [=](int, IterationRecord& r) {
                              r.constraint = violation;
                              r.restoration = restoration;
                            },
                            {.status = status});
  };
  const Diagnosis d = ended(SolveStatus::line_search_failed, 0.5, 1);
  EXPECT_EQ(d.pattern, DiagnosisPattern::undecided);
  EXPECT_NE(d.message.find("below 5.0e-01 at knot 3"), std::string::npos) << d.message;
  EXPECT_NE(d.remedy.find("solver.restarts: {count: 20, spread: 1}"), std::string::npos);
  EXPECT_NE(ended(SolveStatus::line_search_failed, 0.5, 0).pattern, DiagnosisPattern::undecided);
  EXPECT_NE(ended(SolveStatus::line_search_failed, 9e-4, 1).pattern, DiagnosisPattern::undecided);
  EXPECT_NE(ended(SolveStatus::max_iterations, 0.5, 1).pattern, DiagnosisPattern::undecided);
}

TEST(DiagnosisPatterns, StallInShortLogSuggestsMoreIterations) {
  const auto asks = [](SolveStatus status, int rows) {
    const Diagnosis d =
        diagnosis_of_log(rows, [](int, IterationRecord& r) { r.gap = 0.5; }, {.status = status});
    EXPECT_EQ(d.pattern, DiagnosisPattern::open_gaps);
    return d.remedy.starts_with("more iterations (solver.max_iterations); ");
  };
  EXPECT_TRUE(asks(SolveStatus::max_iterations, 21));
  EXPECT_TRUE(asks(SolveStatus::max_iterations, 39));
  EXPECT_FALSE(asks(SolveStatus::max_iterations, 40));
  EXPECT_FALSE(asks(SolveStatus::time_limit, 21));
}

TEST(DiagnosisPatterns, StalledInteriorPointIsNotToldToContinue) {
  const auto ended = [](int rows, double factor) {
    return diagnosis_of_log(rows, [=](int i, IterationRecord& r) {
      r.barrier = 1e-3;
      r.constraint = i < rows / 2 ? 9 : i < rows - 1 ? 1 : factor;
    });
  };
  const Diagnosis d = ended(40, 0.6);
  EXPECT_EQ(d.pattern, DiagnosisPattern::undecided);
  EXPECT_NE(d.message.find("stalled: 6.0e-01 at knot 3 after 1.0e+00 19 iterations before"),
            std::string::npos)
      << d.message;
  EXPECT_EQ(d.remedy.find("more iterations"), std::string::npos);
  EXPECT_EQ(ended(40, 0.4).pattern, DiagnosisPattern::unfinished);
  EXPECT_EQ(ended(39, 0.6).pattern, DiagnosisPattern::unfinished);
}

TEST(DiagnosisPatterns, UnboundedControlsWithViolationNeedLargerPenalty) {
  const auto remedy = [](double limit) {
    return diagnosis_of_log(
               3, [](int, IterationRecord& r) { r.constraint = 0.5; },
               {.status = SolveStatus::infeasible}, testing::pendulum_swing_up(limit))
        .remedy;
  };
  EXPECT_NE(remedy(testing::kFree).find("initial_penalty"), std::string::npos);
  EXPECT_EQ(remedy(3).find("initial_penalty"), std::string::npos);
}

TEST(DiagnosisPatterns, UnboundedLinearCostCastsDoubtOnInfeasibility) {
  const auto remedy = [](const ShootingProblem& problem) {
    return diagnosis_of_log(
               3, [](int, IterationRecord& r) { r.constraint = 0.5; },
               {.status = SolveStatus::infeasible}, problem)
        .remedy;
  };
  EXPECT_NE(remedy(with_linear_cost()).find("--solver ipopt"), std::string::npos);
  EXPECT_EQ(remedy(testing::pendulum_swing_up()).find("--solver ipopt"), std::string::npos);
}

TEST(DiagnosisPatterns, ImmediateSearchFailureMeansGapsOrNoDescent) {
  const Ending stuck{.status = SolveStatus::line_search_failed};
  const Diagnosis gaps = diagnosis_of_log(
      1, [](int, IterationRecord& r) { r.gap = 0.5; }, stuck);
  EXPECT_EQ(gaps.pattern, DiagnosisPattern::open_gaps);
  EXPECT_NE(gaps.message.find("no step lowers the merit"), std::string::npos) << gaps.message;
  EXPECT_EQ(diagnosis_of_log(
                1, [](int, IterationRecord&) {}, stuck)
                .pattern,
            DiagnosisPattern::no_descent);
  const Ending blown_up{.status = SolveStatus::line_search_failed, .failed_knot = 0};
  EXPECT_EQ(diagnosis_of_log(
                1, [](int, IterationRecord& r) { r.gap = 0.5; }, blown_up)
                .pattern,
            DiagnosisPattern::growth);
}

TEST(DiagnosisPatterns, UnfinishedSolveNamesFirstResidualAboveTolerance) {
  const auto with_gap = [](double gap) {
    return diagnosis_of_log(3, [=](int, IterationRecord& r) { r.gap = gap; });
  };
  EXPECT_EQ(with_gap(0).quantity, "stationarity");
  EXPECT_EQ(with_gap(0).knot, 7);
  EXPECT_EQ(with_gap(0.5).quantity, "gap");
  EXPECT_EQ(with_gap(0.5).knot, 5);
}

// Halving and tolerances that are met exactly count as progress.
TEST(DiagnosisPatterns, ExactLimitsCountAsProgress) {
  const double tolerance = SolverOptions{}.tolerances.stationarity;
  EXPECT_EQ(diagnosis_of_log(11,
                             [](int i, IterationRecord& r) {
                               r.stationarity = std::pow(0.1, i);
                               r.gap = i == 10 ? 0.5 : 1;
                             })
                .pattern,
            DiagnosisPattern::unfinished);
  EXPECT_EQ(diagnosis_of_log(6,
                             [](int i, IterationRecord& r) {
                               r.stationarity = std::pow(0.1, i);
                               r.constraint = std::ldexp(1.0, -i);
                             })
                .pattern,
            DiagnosisPattern::unfinished);
  EXPECT_EQ(diagnosis_of_log(6,
                             [=](int, IterationRecord& r) {
                               r.step = 0.1;
                               r.stationarity = tolerance;
                             })
                .pattern,
            DiagnosisPattern::unfinished);
}

// A violation of a thousand tolerances may be rounding; a rising cost never outruns a penalty.
TEST(DiagnosisPatterns, AThousandTolerancesAreNotFarOff) {
  const double limit = 1e3 * SolverOptions{}.tolerances.constraint;
  const auto ended = [&](double violation, std::string_view failed) {
    return diagnosis_of_log(
               12, [=](int, IterationRecord& r) { r.constraint = violation; },
               {.status = SolveStatus::line_search_failed, .failed_quantity = failed},
               with_linear_cost())
        .pattern;
  };
  EXPECT_EQ(ended(limit, kRoundedCost), DiagnosisPattern::rounding_floor);
  EXPECT_EQ(ended(1.1 * limit, kRoundedCost), DiagnosisPattern::outrun_penalty);
  EXPECT_EQ(ended(limit, ""), DiagnosisPattern::slow_feasibility);
  EXPECT_EQ(ended(1.1 * limit, ""), DiagnosisPattern::outrun_penalty) << "a cost that stays";
}

TEST(DiagnosisPatterns, CostStillFallsAtHalfTheEarlierPace) {
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(1, 1);
  const ShootingProblem free =
      testing::tracking_problem(linear_system(one, one, Eigen::VectorXd::Zero(1)),
                                Integrator::discrete, 3, 1, {0}, {{0}, {1}, {0}, {1}});
  const auto falls = [&](int rows, double half, double end) {
    return diagnosis_of_log(
               rows,
               [=](int i, IterationRecord& r) {
                 r.cost = i == rows - 1 ? end : i >= (rows - 1) / 2 ? half : 0;
               },
               {}, free)
               .pattern == DiagnosisPattern::free_control;
  };
  EXPECT_TRUE(falls(5, -2, -3));
  EXPECT_FALSE(falls(5, -2, -2.9));
  EXPECT_FALSE(falls(4, -2, -9)) << "too few rows";
  EXPECT_FALSE(falls(5, 0, -3)) << "nothing fell at first";
  EXPECT_FALSE(falls(5, 1, -3)) << "it rose at first";
}

TEST(DiagnosisPatterns, ResidualsAtTheirTolerancesAreNotMissed) {
  const SolverOptions::Tolerances t;
  const auto at = [&](double gap, double stationarity, double constraint) {
    return diagnosis_of_log(3, [=](int, IterationRecord& r) {
      r.gap = gap;
      r.stationarity = stationarity;
      r.constraint = constraint;
      r.gap_knot = 0;
    });
  };
  EXPECT_NE(at(t.gap, t.stationarity, t.constraint).message.find("all residuals are under"),
            std::string::npos);
  const Diagnosis all = at(1.5 * t.gap, 1.5 * t.stationarity, 1.5 * t.constraint);
  EXPECT_TRUE(all.message.ends_with(
      "gap 1.5e-09 at knot 0, stationarity 1.5e-06 at knot 7, constraint violation 1.5e-06"))
      << all.message;
  EXPECT_EQ(all.quantity, "gap");
}

TEST(DiagnosisPatterns, RoundedStationarityBlamesCostsOrMultipliers) {
  const SolverOptions::Tolerances t;
  const auto remedy = [&](double stationarity, double constraint) {
    return diagnosis_of_log(
               3,
               [=](int, IterationRecord& r) {
                 r.stationarity = stationarity;
                 r.constraint = constraint;
               },
               {.status = SolveStatus::line_search_failed, .failed_quantity = kRoundedCost})
        .remedy;
  };
  EXPECT_EQ(remedy(0, 0), "smaller weights of costs that stay large");
  EXPECT_TRUE(remedy(2 * t.stationarity, 0).ends_with("smaller weights of costs that stay large"));
  EXPECT_TRUE(remedy(0, 2 * t.constraint).ends_with("in which their multipliers are smaller"));
  const std::string both = remedy(2 * t.stationarity, 2 * t.constraint);
  EXPECT_TRUE(both.starts_with(
      "a larger solver.tolerances.stationarity, solver.tolerances.constraint (the answer"))
      << both;
  EXPECT_TRUE(both.ends_with("smaller weights of costs that stay large")) << both;
}

TEST(DiagnosisPatterns, NoDescentAdviceFitsMethodAndGaps) {
  const auto remedy = [](double gap, double barrier) {
    return diagnosis_of_log(3,
                            [=](int, IterationRecord& r) {
                              r.gap = gap;
                              r.barrier = barrier;
                            },
                            {.status = SolveStatus::line_search_failed})
        .remedy;
  };
  EXPECT_TRUE(remedy(0, 0).ends_with("costs that are not smooth")) << remedy(0, 0);
  EXPECT_NE(remedy(1e-12, 0).find("a first guess with smaller gaps"), std::string::npos);
  EXPECT_NE(remedy(0, 1e-9).find("mu_strategy"), std::string::npos);
}

}  // namespace
}  // namespace conddp
