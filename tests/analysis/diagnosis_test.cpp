#include "analysis/findings/diagnosis.hpp"

#include <set>

#include <gtest/gtest.h>

#include "robot/urdf/urdf.hpp"
#include "support/small_problems.hpp"
#include "support/source_tree.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {
namespace {

/// A log of `rows` iterations, row by row from a function.
template <class Row>
Diagnosis diagnosis_of(int rows, Row row, SolveStatus status = SolveStatus::max_iterations,
                       const ShootingProblem& problem = testing::pendulum_swing_up(),
                       std::string_view failed = "") {
  SolveResult result(problem);
  result.failed_quantity = failed;
  result.status = status;
  for (int i = 0; i < rows; ++i) {
    IterationRecord r;
    r.iteration = i;
    r.stationarity_knot = 7;
    r.gap_knot = 5;
    r.stationarity = 1;
    r.step = 1;
    row(i, r);
    result.log.push_back(r);
  }
  result.iterations = rows - 1;
  const IterationRecord& last = result.log.back();
  result.residuals = {.stationarity = last.stationarity,
                      .gap = last.gap,
                      .constraint = last.constraint,
                      .complementarity = last.complementarity,
                      .stationarity_knot = last.stationarity_knot,
                      .gap_knot = last.gap_knot,
                      .constraint_knot = last.constraint_knot};
  return diagnose(problem, result, {});
}

TEST(Diagnosis, NamesAreDistinct) {
  std::set<std::string_view> names;
  for (int i = 0; i <= static_cast<int>(DiagnosisPattern::unfinished); ++i)
    names.insert(to_string(static_cast<DiagnosisPattern>(i)));
  EXPECT_EQ(names.size(), 15u);
}

TEST(Diagnosis, OpenGapsComeFirst) {
  const Diagnosis d = diagnosis_of(12, [](int i, IterationRecord& r) {
    r.step = 0.01;
    r.gap = 1 - 0.01 * i;
  });
  EXPECT_EQ(d.pattern, DiagnosisPattern::open_gaps);
  EXPECT_EQ(d.knot, 5);
}

TEST(Diagnosis, SlowFeasibilityNeedsFullStepsAndSlowViolation) {
  const auto violation = [](double factor, double step) {
    return diagnosis_of(8, [=](int i, IterationRecord& r) {
      r.stationarity = std::pow(0.1, i);
      r.constraint = std::pow(factor, i);
      r.step = step;
    });
  };
  EXPECT_EQ(violation(0.8, 1).pattern, DiagnosisPattern::slow_feasibility);
  EXPECT_EQ(violation(0.2, 1).pattern, DiagnosisPattern::unfinished);
  EXPECT_EQ(violation(0.8, 0.5).pattern, DiagnosisPattern::unfinished);
}

TEST(Diagnosis, PlateauHasSmallStepsOrRegularization) {
  const auto stands = [](double step, double regularization) {
    return diagnosis_of(20, [=](int, IterationRecord& r) {
      r.step = step;
      r.regularization = regularization;
    });
  };
  EXPECT_EQ(stands(0.125, 0).pattern, DiagnosisPattern::plateau);
  EXPECT_EQ(stands(1, 10).pattern, DiagnosisPattern::plateau);
  EXPECT_NE(stands(1, 10).remedy, stands(0.125, 0).remedy);
  EXPECT_EQ(stands(1, 0).pattern, DiagnosisPattern::unfinished);
}

TEST(Diagnosis, AFewRowsShowNoPattern) {
  const Diagnosis d = diagnosis_of(3, [](int, IterationRecord& r) { r.step = 0.01; });
  EXPECT_EQ(d.pattern, DiagnosisPattern::unfinished);
  EXPECT_EQ(d.knot, 7);
}

TEST(Diagnosis, InfeasibleBoundedControlsGetNoPenaltyAdvice) {
  const Diagnosis d = diagnosis_of(
      8,
      [](int, IterationRecord& r) {
        r.constraint = 2;
        r.constraint_knot = 4;
      },
      SolveStatus::infeasible, testing::pendulum_swing_up(3));
  EXPECT_EQ(d.pattern, DiagnosisPattern::infeasible);
  EXPECT_EQ(d.knot, 4);
  EXPECT_EQ(d.remedy.find("penalty"), std::string::npos) << d.remedy;
}

TEST(Diagnosis, InteriorPointGetsNoRegularizationAdvice) {
  for (const SolveStatus status :
       {SolveStatus::max_iterations, SolveStatus::time_limit, SolveStatus::line_search_failed,
        SolveStatus::regularization_limit}) {
    const Diagnosis d = diagnosis_of(
        12,
        [](int, IterationRecord& r) {
          r.step = 0.1;
          r.regularization = 1;
          r.barrier = 1e-3;
        },
        status);
    EXPECT_EQ(d.remedy.find("solver.regularization"), std::string::npos) << d.remedy;
  }
}

TEST(Diagnosis, AdvisesLargerToleranceForTheMissedResidual) {
  const auto ended = [](double stationarity, double complementarity) {
    return diagnosis_of(
        8,
        [=](int, IterationRecord& r) {
          r.stationarity = stationarity;
          r.complementarity = complementarity;
        },
        SolveStatus::line_search_failed, testing::pendulum_swing_up(), kRoundedCost);
  };
  const Diagnosis pairs = ended(1e-8, 3e-5);
  EXPECT_EQ(pairs.pattern, DiagnosisPattern::rounding_floor);
  EXPECT_EQ(pairs.quantity, "complementarity");
  EXPECT_NE(pairs.message.find("complementarity 3.0e-05"), std::string::npos) << pairs.message;
  EXPECT_NE(pairs.remedy.find("solver.tolerances.complementarity"), std::string::npos);
  EXPECT_EQ(pairs.remedy.find("stationarity"), std::string::npos) << pairs.remedy;
  const Diagnosis gradient = ended(3e-5, 1e-8);
  EXPECT_EQ(gradient.quantity, "stationarity");
  EXPECT_NE(gradient.remedy.find("solver.tolerances.stationarity"), std::string::npos);
  EXPECT_EQ(gradient.remedy.find("complementarity"), std::string::npos) << gradient.remedy;
}

/// A point mass whose push has weight r, within a limit.
ShootingProblem push(double r, double limit = testing::kFree) {
  return testing::tracking_problem(double_integrator(1), Integrator::rk4, 9, 0.1, {0, 0},
                                   {.goal = {1, 0}, .q = {1, 1}, .r = {r}, .qf = {1, 1}}, -limit,
                                   limit);
}

TEST(Diagnosis, NamesUnboundedControlWhileCostFalls) {
  const auto falling = [](const ShootingProblem& problem, double last) {
    return diagnosis_of(
        12, [&](int i, IterationRecord& r) { r.cost = i < 6 ? -10.0 * i : -50 - last * (i - 5); },
        SolveStatus::max_iterations, problem);
  };
  const Diagnosis found = falling(push(0), 10);
  EXPECT_EQ(found.pattern, DiagnosisPattern::free_control);
  EXPECT_EQ(found.knot, 0);
  EXPECT_TRUE(found.message.ends_with("; the cost keeps falling, to -110, and the control '" +
                                      found.quantity +
                                      "' has neither a cost nor a bound in the phase 'all'"))
      << found.message;
  EXPECT_NE(falling(push(0), 1).pattern, DiagnosisPattern::free_control) << "it settles";
  EXPECT_NE(falling(push(1), 10).pattern, DiagnosisPattern::free_control) << "a cost";
  EXPECT_NE(falling(push(0, 3), 10).pattern, DiagnosisPattern::free_control) << "a bound";
}

/// The planar hopper on contacts of its foot.
ShootingProblem standing(int contacts) {
  const UrdfResult urdf =
      load_urdf(source_tree() / "problems/robots/hopper.urdf", {.base = UrdfOptions::Base::planar});
  const auto robot = std::make_shared<const RobotModel>(urdf.model.value());
  std::vector<Contact> feet;
  for (int i = 0; i < contacts; ++i)
    feet.push_back({.name = "foot" + std::to_string(i), .frame = *robot->find_frame("foot")});
  const auto system = std::make_shared<MultibodySystem>(
      robot, Actuation::joints(*robot, {"hip", "knee"}), PassiveForces{}, feet);
  const std::vector<double> start = {0, 0.5, 0, 0.5, -1, 0, 0, 0, 0, 0};
  const std::vector<double> ones(10, 1);
  return testing::tracking_problem(system, Integrator::semi_implicit_euler, 9, 0.01, start,
                                   {.goal = start, .q = ones, .r = {1, 1}, .qf = ones});
}

// A foot held by two contacts has four rows in its plane, two of them redundant. The row normal to
// the plane, where nothing moves, does not make a single contact redundant.
TEST(Diagnosis, NamesRedundantContactsInsteadOfTheGuess) {
  const auto open = [](const ShootingProblem& problem) {
    return diagnosis_of(
        12, [](int, IterationRecord& r) { r.gap = 1; }, SolveStatus::line_search_failed, problem);
  };
  const Diagnosis twice = open(standing(2));
  EXPECT_EQ(twice.pattern, DiagnosisPattern::redundant_contacts);
  EXPECT_EQ(twice.knot, 5);
  EXPECT_NE(twice.message.find("'foot0', 'foot1' are redundant there: of all 4 rows 2 are"),
            std::string::npos)
      << twice.message;
  EXPECT_EQ(twice.remedy.find("first guess"), std::string::npos) << twice.remedy;
  const Diagnosis once = open(standing(1));
  EXPECT_EQ(once.pattern, DiagnosisPattern::open_gaps) << once.message;
  // Contacts belong to knots: not to the terminal node, and not to an unspecified knot.
  for (const int knot : {0, 9, -1}) {
    const Diagnosis elsewhere = diagnosis_of(
        12,
        [=](int, IterationRecord& r) {
          r.gap = 1;
          r.gap_knot = knot;
        },
        SolveStatus::line_search_failed, standing(2));
    EXPECT_EQ(elsewhere.pattern,
              knot == 0 ? DiagnosisPattern::redundant_contacts : DiagnosisPattern::open_gaps)
        << knot;
  }
}

TEST(Diagnosis, OnlyTheLastRowsCount) {
  const Diagnosis d = diagnosis_of(40, [](int i, IterationRecord& r) {
    r.step = i < 25 ? 0.01 : 1;
    r.stationarity = i < 25 ? 1 : std::pow(0.3, i - 25);
  });
  EXPECT_EQ(d.pattern, DiagnosisPattern::unfinished);
}

}  // namespace
}  // namespace conddp
