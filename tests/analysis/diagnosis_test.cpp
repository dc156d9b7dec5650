#include "analysis/diagnosis.hpp"

#include <gtest/gtest.h>

#include "support/small_problems.hpp"

namespace conddp {
namespace {

/// A log of `rows` iterations, row by row from a function.
template <class Row>
Diagnosis diagnosis_of(int rows, Row row, SolveStatus status = SolveStatus::max_iterations) {
  SolveResult result(testing::pendulum_swing_up());
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
  result.residuals.stationarity = result.log.back().stationarity;
  result.residuals.gap = result.log.back().gap;
  return diagnose(result, {});
}

TEST(Diagnosis, NamesAreDistinct) {
  std::set<std::string_view> names;
  for (int i = 0; i <= static_cast<int>(DiagnosisPattern::unfinished); ++i)
    names.insert(to_string(static_cast<DiagnosisPattern>(i)));
  EXPECT_EQ(names.size(), 11u);
}

TEST(Diagnosis, GapsThatStayOpenComeBeforeEverythingElse) {
  const Diagnosis d = diagnosis_of(12, [](int i, IterationRecord& r) {
    r.step = 0.01;
    r.gap = 1 - 0.01 * i;
  });
  EXPECT_EQ(d.pattern, DiagnosisPattern::open_gaps);
  EXPECT_EQ(d.knot, 5);
}

TEST(Diagnosis, SlowFeasibilityNeedsFullStepsAndAViolationThatHardlyFalls) {
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

TEST(Diagnosis, APlateauIsOneWithSmallStepsOrRegularisation) {
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

TEST(Diagnosis, InfeasibleProblemsAreNotAskedForLargerPenalties) {
  const Diagnosis d = diagnosis_of(
      8,
      [](int, IterationRecord& r) {
        r.constraint = 2;
        r.constraint_knot = 4;
      },
      SolveStatus::infeasible);
  EXPECT_EQ(d.pattern, DiagnosisPattern::infeasible);
  EXPECT_EQ(d.knot, 4);
  EXPECT_EQ(d.remedy.find("penalty"), std::string::npos) << d.remedy;
}

TEST(Diagnosis, AnInteriorPointMethodIsGivenNoAdviceOnRegularisation) {
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
    EXPECT_EQ(d.remedy.find("line_search"), std::string::npos) << d.remedy;
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
