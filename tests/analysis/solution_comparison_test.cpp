#include "analysis/comparison/solution_comparison.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace conddp {
namespace {

using Json = nlohmann::json;

Json solution() {
  return {{"format", 1},
          {"solver", "box_fddp"},
          {"status", "converged"},
          {"iterations", 7},
          {"cost", 2.0},
          {"cost_by_name", {{"state", 1.5}, {"terminal/state", 0.5}}},
          {"residuals", {{"stationarity", 1e-8}, {"gap", 0.0}}},
          {"trajectory",
           {{"columns",
             {{"x", {"base/qx", "base/qy", "base/qz", "base/qw", "v/elbow"}}, {"u", {"u/elbow"}}}},
            {"t", {0.0, 0.1}},
            {"x", {{0.0, 0.0, 0.0, 1.0, 2.0}, {0.0, 0.0, 0.6, 0.8, 1.0}}},
            {"u", {{3.0}}}}}};
}

std::string first(const Json& a, const Json& b) {
  const auto differences = compare_solutions(a, b);
  return differences.empty() ? "" : differences.front().quantity;
}

TEST(SolutionComparison, ASolutionAgreesWithItselfAndWithItsGoldenPart) {
  EXPECT_EQ(first(solution(), solution()), "");
  EXPECT_EQ(first(golden_part(solution()), solution()), "");
}

TEST(SolutionComparison, TheNumberOfIterationsDoesNotMatter) {
  Json other = solution();
  other["iterations"] = 70;
  EXPECT_EQ(first(solution(), other), "");
}

TEST(SolutionComparison, AQuaternionAndItsNegativeAreTheSameRotation) {
  Json other = solution();
  other["trajectory"]["x"][1] = {0.0, 0.0, -0.6, -0.8, 1.0};
  EXPECT_EQ(first(solution(), other), "");
}

TEST(SolutionComparison, SlipSpeedsThatNoForceTellsDoNotMatter) {
  const auto with = [](const char* name, double value) {
    Json j = solution();
    j["trajectory"]["columns"]["u"] = {"u/elbow", name};
    j["trajectory"]["u"] = {{3.0, value}};
    return j;
  };
  for (const char* slack : {"contact/toe/slip_t-", "contact/toe/slip_speed", "contact/toe/use1"})
    EXPECT_EQ(first(with(slack, 0.0), with(slack, 0.1)), "") << slack;
  for (const char* force : {"contact/toe/fn", "contact/toe/ft+", "contact/use/fn",
                            "contact/slip_1/fn", "friction/hip/slip_t+"})
    EXPECT_NE(first(with(force, 0.0), with(force, 0.1)), "") << force;
}

TEST(SolutionComparison, MissingNumbersAgreeWithNothing) {
  for (const int column : {2, 4}) {  // of a rotation, and of a number
    Json good = solution();
    good["trajectory"]["t"] = {0.0, 0.1, 0.2};
    good["trajectory"]["x"].push_back({0.0, 0.0, 0.6, 0.8, 1.0});
    good["trajectory"]["u"].push_back({3.0});
    Json bad = good;
    bad["trajectory"]["x"][1][column] = nullptr;
    for (const auto& [golden, actual] : {std::pair(good, bad), {bad, good}, {bad, bad}})
      EXPECT_TRUE(first(golden, actual).ends_with("at knot 1 (t = 0.1 s)"))
          << first(golden, actual);
  }
}

TEST(SolutionComparison, NamesWhatDiffersAndWhere) {
  const auto changed = [](auto change) {
    Json other = solution();
    change(other);
    return first(solution(), other);
  };
  EXPECT_EQ(changed([](Json& j) { j["status"] = "diverged"; }), "status");
  EXPECT_EQ(changed([](Json& j) { j["cost"] = 2.00001; }), "cost");
  EXPECT_EQ(changed([](Json& j) { j["cost"] = nullptr; }), "cost");
  EXPECT_EQ(changed([](Json& j) { j["cost_by_name"]["state"] = 1.6; }), "cost state");
  EXPECT_EQ(changed([](Json& j) { j["cost_by_name"].erase("state"); }), "cost state");
  EXPECT_EQ(changed([](Json& j) { j["residuals"]["gap"] = 1e-3; }), "residual gap");
  EXPECT_EQ(changed([](Json& j) { j["trajectory"]["t"][1] = 0.2; }), "trajectory");
  EXPECT_EQ(changed([](Json& j) { j["trajectory"]["u"][0][0] = 3.1; }),
            "trajectory u/elbow at knot 0 (t = 0 s)");
  EXPECT_EQ(changed([](Json& j) { j["trajectory"]["x"][1][4] = 1.1; }),
            "trajectory v/elbow at knot 1 (t = 0.1 s)");
  EXPECT_EQ(changed([](Json& j) {
              j["trajectory"]["x"][1][3] = 0.7;
              j["trajectory"]["x"][1][2] = 0.714;
            }),
            "trajectory base/rotation at knot 1 (t = 0.1 s)");
  EXPECT_EQ(changed([](Json& j) { j.erase("trajectory"); }), "document");
}

TEST(SolutionComparison, DocumentsOfAnotherShapeAreRefused) {
  const auto defect = [](auto change) {
    Json other = solution();
    change(other);
    return comparison_defect(other).value_or("");
  };
  EXPECT_EQ(defect([](Json&) {}), "");
  EXPECT_EQ(defect([](Json& j) { j["trajectory"]["x"][1][4] = nullptr; }), "");
  EXPECT_EQ(defect([](Json& j) { j["trajectory"]["u"][0] = Json::array(); }), "");
  EXPECT_EQ(defect([](Json& j) { j["cost"] = "low"; }), "the cost is not a number");
  EXPECT_EQ(defect([](Json& j) {
              j["trajectory"]["x"][1] = Json::array({1, 2});
            }),
            "a row of 'x' should have 5 numbers");
  EXPECT_EQ(defect([](Json& j) { j["trajectory"]["x"][0] = Json::array(); }),
            "a row of 'x' is empty");
  EXPECT_EQ(defect([](Json& j) { j["trajectory"]["u"] = Json::array(); }),
            "'u' should have 1 rows");
  EXPECT_EQ(defect([](Json& j) { j["trajectory"]["t"] = Json::array(); }),
            "'trajectory.t' is not a list of times");
  EXPECT_EQ(defect([](Json& j) { j = Json::array(); }), "'status' is missing");
}

TEST(SolutionComparison, ANumberThatIsNotFiniteAgreesWithNoOther) {
  const auto changed = [](auto change) {
    Json other = solution();
    change(other);
    return first(solution(), other);
  };
  EXPECT_EQ(changed([](Json& j) { j["residuals"]["gap"] = nullptr; }), "residual gap");
  EXPECT_EQ(changed([](Json& j) { j["trajectory"]["x"][1][4] = nullptr; }),
            "trajectory v/elbow at knot 1 (t = 0.1 s)");
}

}  // namespace
}  // namespace conddp
