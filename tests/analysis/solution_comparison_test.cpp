#include "analysis/comparison/solution_comparison.hpp"

#include <array>
#include <cmath>

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

TEST(SolutionComparison, AgreesWithItselfAndItsGoldenPart) {
  EXPECT_EQ(first(solution(), solution()), "");
  EXPECT_EQ(first(golden_part(solution()), solution()), "");
}

TEST(SolutionComparison, GoldenPartRoundsSubnormalNumbers) {
  Json tiny = solution();
  tiny["cost"] = 4e-320;
  EXPECT_LT(golden_part(tiny)["cost"].get<double>(), 1e-300);
}

TEST(SolutionComparison, IgnoresTheNumberOfIterations) {
  Json other = solution();
  other["iterations"] = 70;
  EXPECT_EQ(first(solution(), other), "");
}

TEST(SolutionComparison, QuaternionEqualsItsNegative) {
  Json other = solution();
  other["trajectory"]["x"][1] = {0.0, 0.0, -0.6, -0.8, 1.0};
  EXPECT_EQ(first(solution(), other), "");
}

// A rotation by 2 mrad about each axis from a quaternion without zeros.
TEST(SolutionComparison, RotationsAreComparedByTheirAngle) {
  const std::array<double, 4> q = {0.1, 0.5, -0.7, 0.5};  // x y z w, of unit length
  const auto turned = [&](int axis, double angle) {
    // q ⊗ (sin(angle/2) e, cos(angle/2))
    std::array<double, 3> s = {0, 0, 0};
    s[axis] = std::sin(angle / 2);
    const double c = std::cos(angle / 2);
    Json j = solution();
    j["trajectory"]["x"][1] = {q[3] * s[0] + q[0] * c + q[1] * s[2] - q[2] * s[1],
                               q[3] * s[1] + q[1] * c + q[2] * s[0] - q[0] * s[2],
                               q[3] * s[2] + q[2] * c + q[0] * s[1] - q[1] * s[0],
                               q[3] * c - q[0] * s[0] - q[1] * s[1] - q[2] * s[2], 1.0};
    return j;
  };
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(first(turned(axis, 0), turned(axis, 9e-4)), "") << axis;
    const auto differences = compare_solutions(turned(axis, 0), turned(axis, 0.002));
    ASSERT_EQ(differences.size(), 1u) << axis;
    EXPECT_EQ(differences[0].quantity, "trajectory base/rotation at knot 1 (t = 0.1 s)");
    EXPECT_NE(differences[0].message.find("turned by 0.002 rad"), std::string::npos)
        << differences[0].message;
  }
}

TEST(SolutionComparison, TolerancesScaleWithLargestEntryOfColumn) {
  const auto with = [](double changed) {
    Json j = solution();
    j["trajectory"]["x"][1][4] = changed;  // against 2: within 1e-4 + 1e-3 · 2
    return j;
  };
  EXPECT_EQ(first(solution(), with(1.00209)), "");
  EXPECT_NE(first(solution(), with(1.00211)), "");
  EXPECT_EQ(first(solution(), with(0.99791)), "");
  EXPECT_NE(first(solution(), with(0.99789)), "");
}

TEST(SolutionComparison, ResidualsMayGrowTenfoldOrToAFloor) {
  const auto with = [](double stationarity) {
    Json j = solution();
    j["residuals"]["stationarity"] = stationarity;
    return j;
  };
  EXPECT_EQ(first(with(1e-6), with(0.99e-5)), "");
  EXPECT_EQ(first(with(1e-6), with(1.01e-5)), "residual stationarity");
  EXPECT_EQ(first(with(1e-9), with(0.99e-6)), "");
  EXPECT_EQ(first(with(1e-9), with(1.01e-6)), "residual stationarity");
}

TEST(SolutionComparison, CostsAreRelativeAndPartsLooser) {
  const auto with = [](double cost, double part) {
    Json j = solution();
    j["cost"] = cost;
    j["cost_by_name"]["state"] = part;
    return j;
  };
  EXPECT_EQ(first(solution(), with(2 + 1.9e-6, 1.5 + 1.9e-4)), "");
  EXPECT_EQ(first(solution(), with(2 + 2.1e-6, 1.5)), "cost");
  EXPECT_EQ(first(solution(), with(2, 1.5 + 2.1e-4)), "cost state");
  // Small costs are compared relative to a thousandth.
  Json small = solution(), other = small;
  small["cost"] = 1e-5;
  other["cost"] = 1e-5 + 0.9e-9;
  EXPECT_EQ(first(small, other), "");
  other["cost"] = 1e-5 + 1.1e-9;
  EXPECT_EQ(first(small, other), "cost");
}

TEST(SolutionComparison, IgnoresSlipSpeedsWithoutForce) {
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

TEST(SolutionComparison, MissingNumbersMatchNothing) {
  for (const int column : {2, 4}) {  // of a rotation and of a number
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

TEST(SolutionComparison, TimesAgreeToABillionth) {
  const auto differs = [](double time, double off) {
    Json a = solution(), b = solution();
    a["trajectory"]["t"] = {0.0, time};
    b["trajectory"]["t"] = {0.0, time + off};
    return first(a, b) == "trajectory";
  };
  EXPECT_FALSE(differs(1e-3, 0.9e-9));
  EXPECT_TRUE(differs(1e-3, 1.1e-9));
  EXPECT_FALSE(differs(1000, -0.9e-6));
  EXPECT_TRUE(differs(1000, -1.1e-6));
  Json a = solution(), b = solution();
  b["trajectory"]["t"] = {1e-8, 0.1};
  EXPECT_EQ(first(a, b), "trajectory");
}

TEST(SolutionComparison, NamesDifferencesAndTheirPlaces) {
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

TEST(SolutionComparison, RejectsDocumentsOfAnotherShape) {
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

TEST(SolutionComparison, NonFiniteNumberMatchesNothing) {
  const auto changed = [](auto change) {
    Json other = solution();
    change(other);
    return first(solution(), other);
  };
  EXPECT_EQ(changed([](Json& j) { j["residuals"]["gap"] = nullptr; }), "residual gap");
  EXPECT_EQ(changed([](Json& j) { j["trajectory"]["x"][1][4] = nullptr; }),
            "trajectory v/elbow at knot 1 (t = 0.1 s)");
}

TEST(SolutionComparison, AbsentControlMatchesAbsentControl) {
  Json two = solution();
  two["trajectory"]["columns"]["u"] = {"u/elbow", "u/wrist"};
  two["trajectory"]["u"] = {{3.0, nullptr}};
  EXPECT_EQ(first(two, two), "");
  Json other = two;
  other["trajectory"]["u"] = {{3.0, 1.0}};
  EXPECT_EQ(first(two, other), "trajectory u/wrist at knot 0 (t = 0 s)");
  two["trajectory"]["u"] = {{nullptr, nullptr}};
  EXPECT_EQ(first(two, two), "trajectory u/elbow at knot 0 (t = 0 s)") << "no number at all";
}

// Columns of a body: its position, a rotation starting at the second column, and a joint after it.
TEST(SolutionComparison, FindsRotationsByFourConsecutiveNames) {
  const auto with = [](std::vector<std::string> names, int column, double change) {
    Json j = solution();
    j["trajectory"]["columns"]["x"] = std::move(names);
    j["trajectory"]["x"] = {{1.0, 0.0, 0.0, 0.6, 0.8, 2.0}, {1.5, 0.0, 0.6, 0.0, 0.8, 3.0}};
    double& number = j["trajectory"]["x"][1][column].get_ref<double&>();
    number += change;
    return j;
  };
  const auto told = [&](const std::vector<std::string>& names, int column) {
    return first(with(names, column, 0), with(names, column, 0.01));
  };
  const std::vector<std::string> body = {"a/x", "a/qx", "a/qy", "a/qz", "a/qw", "q/b"};
  const std::vector<std::string> numbers = {"q/a", "a/qx", "a/qy", "a/qz", "q/b", "q/c"};
  for (const int column : {0, 5}) {
    EXPECT_EQ(told(body, column), "trajectory " + body[column] + " at knot 1 (t = 0.1 s)");
  }
  for (const int column : {1, 2, 3, 4})
    EXPECT_EQ(told(body, column), "trajectory a/rotation at knot 1 (t = 0.1 s)") << column;
  for (int column = 0; column < 6; ++column)
    EXPECT_EQ(told(numbers, column), "trajectory " + numbers[column] + " at knot 1 (t = 0.1 s)");
}

TEST(SolutionComparison, DifferencesAreFoundAtEveryNode) {
  Json good = solution();
  good["trajectory"]["t"] = {0.0, 0.1, 0.2};
  good["trajectory"]["x"].push_back({0.0, 0.0, 0.6, 0.8, 1.0});
  good["trajectory"]["u"].push_back({3.0});
  for (int node = 0; node < 3; ++node) {
    const std::string place = " at knot " + std::to_string(node) + " (t = " +
                              (node == 0   ? "0"
                               : node == 1 ? "0.1"
                                           : "0.2") +
                              " s)";
    Json turned = good, moved = good, pushed = good;
    turned["trajectory"]["x"][node][0] = 0.01;
    EXPECT_EQ(first(good, turned), "trajectory base/rotation" + place);
    moved["trajectory"]["x"][node][4] = 1.5;
    EXPECT_EQ(first(good, moved), "trajectory v/elbow" + place);
    if (node == 2) continue;
    pushed["trajectory"]["u"][node][0] = 3.5;
    EXPECT_EQ(first(good, pushed), "trajectory u/elbow" + place);
  }
}

// If the first two nodes share one time, the first controls choose the initial state.
TEST(SolutionComparison, IgnoresTheInitialStateChoice) {
  const auto with = [](double second, double choice) {
    Json j = solution();
    j["trajectory"]["t"] = {0.0, second};
    j["trajectory"]["u"][0][0] = choice;
    return j;
  };
  EXPECT_EQ(first(with(0, 3), with(0, 4)), "");
  EXPECT_EQ(first(with(0.1, 3), with(0.1, 4)), "trajectory u/elbow at knot 0 (t = 0 s)");
}

TEST(SolutionComparison, RotationMayBeTheLastColumns) {
  const auto with = [](double sign) {
    Json j = solution();
    j["trajectory"]["columns"]["x"] = {"q/a", "a/qx", "a/qy", "a/qz", "a/qw"};
    j["trajectory"]["x"] = {{2.0, 0.0, 0.0, 0.0, 1.0}, {1.0, 0.0, 0.0, sign * 0.6, sign * 0.8}};
    return j;
  };
  EXPECT_EQ(first(with(1), with(-1)), "");
}

TEST(SolutionComparison, NumbersMissingInBothAreEqual) {
  const auto without = [](auto remove) {
    Json j = solution();
    remove(j);
    return j;
  };
  for (const Json& none : {without([](Json& j) { j["cost"] = nullptr; }),
                           without([](Json& j) { j["cost_by_name"]["state"] = nullptr; }),
                           without([](Json& j) { j["residuals"]["gap"] = nullptr; })})
    EXPECT_EQ(first(none, none), "") << none;
  const Json no_cost = without([](Json& j) { j["cost"] = nullptr; });
  EXPECT_EQ(first(no_cost, solution()), "cost");
}

TEST(SolutionComparison, NamesTheDifferenceInTableShape) {
  const auto message = [](auto change) {
    Json other = solution();
    change(other);
    const auto differences = compare_solutions(solution(), other);
    return differences.size() == 1 ? differences[0].message : "";
  };
  EXPECT_EQ(message([](Json& j) { j["trajectory"]["u"][0] = Json::array(); }),
            "knot 0 has 0 numbers of u instead of 1");
  EXPECT_EQ(message([](Json& j) { j["trajectory"]["columns"]["u"][0] = "u/knee"; }),
            "the columns of u have other names");
  EXPECT_EQ(message([](Json& j) {
              j["trajectory"]["t"].push_back(0.2);
              j["trajectory"]["x"].push_back(j["trajectory"]["x"][1]);
              j["trajectory"]["u"].push_back({3.0});
            }),
            "3 nodes instead of 2");
  EXPECT_EQ(message([](Json& j) { j["trajectory"]["t"][1] = 0.25; }),
            "node 1 at t = 0.25 s instead of 0.1 s");
  EXPECT_EQ(message([](Json& j) { j["cost_by_name"]["more"] = 0; }), "is new");
}

}  // namespace
}  // namespace conddp
