#include "batch/session/problem_server.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace conddp {
namespace {

using Json = nlohmann::ordered_json;

const Json kMass = {
    {"conddp", 1},
    {"name", "mass"},
    {"system",
     {{"states", {{"x", "m"}, {"v", "m/s"}}},
      {"controls", {{"force", "N"}}},
      {"rate", {{"x", "v"}, {"v", "force"}}}}},
    {"initial_state", {{"values", {{"x", 0}}}}},
    {"phases", {{{"name", "go"}, {"knots", 20}, {"dt", 0.05}}}},
    {"costs", {{"effort", {{"residual", "control"}, {"weight", 0.1}}}}},
    {"terminal", {{"constraints", {{"there", {{"residual", "state"}, {"reference", {1, 0}}}}}}}},
    {"solver", {{"name", "altro"}}}};

class ProblemServerTest : public testing::Test {
 protected:
  ProblemServerTest() { ask({{"do", "load"}, {"problem", "mass"}, {"content", kMass}}); }

  Json ask(const Json& request) { return Json::parse(server_.reply(request.dump())); }
  Json ask_text(const std::string& request) { return Json::parse(server_.reply(request)); }
  Json solve(Json more = Json::object()) {
    more.update({{"do", "solve"}, {"problem", "mass"}});
    return ask(more);
  }

  ProblemServer server_{[](SolverOptions&) { return nullptr; }};
};

TEST_F(ProblemServerTest, LoadTellsNamesAndSize) {
  const Json reply =
      ask({{"id", "a"}, {"do", "load"}, {"problem", "again"}, {"content", kMass.dump()}});
  EXPECT_EQ(reply["id"], "a");
  EXPECT_EQ(reply["problem"]["columns"]["x"], Json::array({"x", "v"}));
  EXPECT_EQ(reply["problem"]["knots"], 20);
  EXPECT_EQ(reply["messages"], Json::array());
}

TEST_F(ProblemServerTest, SolveRepliesWithCertifiedMotion) {
  const Json reply = solve({{"id", 7}});
  EXPECT_EQ(reply["id"], 7);
  const Json& solution = reply["solution"];
  EXPECT_EQ(solution["status"], "converged");
  EXPECT_EQ(solution["certificate"]["verdict"], "local_minimum");
  EXPECT_NEAR(solution["trajectory"]["x"].back()[0].get<double>(), 1, 1e-6);
  EXPECT_FALSE(solution.contains("gains"));
}

TEST_F(ProblemServerTest, PartsSelectLargeMembers) {
  const Json solution = solve({{"parts", Json::array({"gains"})}, {"verify", false}})["solution"];
  EXPECT_EQ(solution["gains"]["K"].size(), 20u);
  EXPECT_FALSE(solution.contains("trajectory"));
  EXPECT_FALSE(solution.contains("certificate"));
}

TEST_F(ProblemServerTest, SettingsHoldForOneSolve) {
  const double heavy = solve({{"set", {{"costs.effort.weight", 0.2}}}})["solution"]["cost"];
  const double light = solve()["solution"]["cost"];
  EXPECT_NEAR(heavy, 2 * light, 1e-6 * heavy);
}

TEST_F(ProblemServerTest, KeptAnswersAreStarts) {
  EXPECT_EQ(solve({{"keep", "first"}})["solution"]["initial_guess_used"]["multipliers"], "none");
  const Json warm = solve({{"start", "first"}})["solution"];
  EXPECT_EQ(warm["initial_guess_used"]["multipliers"], "those of the former answer");
  EXPECT_EQ(warm["status"], "converged");
}

TEST_F(ProblemServerTest, DroppedNamesAreGone) {
  solve({{"keep", "first"}});
  EXPECT_FALSE(ask({{"do", "drop"}, {"answer", "first"}}).contains("error"));
  EXPECT_EQ(solve({{"start", "first"}})["error"]["message"],
            "'start': nothing is kept under the name 'first'");
  EXPECT_FALSE(ask({{"do", "drop"}, {"problem", "mass"}}).contains("error"));
  EXPECT_EQ(solve()["error"]["message"], "'problem': nothing is kept under the name 'mass'");
}

TEST_F(ProblemServerTest, ErrorsOfProblemsHavePlaces) {
  const Json reply = solve({{"set", {{"costs.effort.wieght", 1}}}});
  EXPECT_EQ(reply["error"]["message"], "the problem has errors");
  ASSERT_EQ(reply["messages"].size(), 1u);
  EXPECT_EQ(reply["messages"][0]["path"], "costs.effort.wieght");
  EXPECT_EQ(reply["messages"][0]["hint"], "did you mean 'weight'?");
}

TEST_F(ProblemServerTest, AnswersOfOtherSystemsAreNoStarts) {
  Json other = kMass;
  other["system"]["states"]["z"] = "m";
  other["system"]["rate"]["z"] = "0";
  other["terminal"]["constraints"]["there"]["reference"] = {1, 0, 0};
  ask({{"do", "load"}, {"problem", "other"}, {"content", other}});
  const Json kept = ask({{"do", "solve"}, {"problem", "other"}, {"keep", "foreign"}});
  ASSERT_TRUE(kept.contains("solution")) << kept;
  EXPECT_NE(solve({{"start", "foreign"}})["error"]["message"].get<std::string>().find(
                "other states or phases"),
            std::string::npos);
}

TEST_F(ProblemServerTest, HostileRequestsGetErrors) {
  for (const std::string& request :
       {std::string("nonsense"), std::string("[]"), std::string("{\"do\": 1}"),
        std::string("{\"do\": \"sing\"}"), std::string("{\"do\": \"solve\", \"problem\": {}}"),
        std::string("{\"id\": [1], \"do\": \"drop\"}"), std::string("{\"id\": \"\xff\"}"),
        std::string("{\"do\": \"load\", \"problem\": \"p\"}"),
        std::string("{\"do\": \"load\", \"problem\": \"p\", \"file\": \"missing.yaml\"}"),
        std::string("{\"do\": \"load\", \"problem\": \"p\", \"content\": \"[\"}"),
        std::string("{\"do\": \"load\", \"problem\": \"p\", \"content\": 1e999}"),
        std::string("{\"do\": \"solve\", \"problem\": \"mass\", \"other\": 1}"),
        std::string("{\"do\": \"solve\", \"problem\": \"mass\", \"parts\": [3]}"),
        std::string("{\"do\": \"solve\", \"problem\": \"mass\", \"parts\": {}}"),
        std::string("{\"do\": \"solve\", \"problem\": \"mass\", \"set\": [1]}"),
        std::string("{\"do\": \"solve\", \"problem\": \"mass\", \"set\": {\"\": {}}}"),
        std::string("{\"do\": \"drop\", \"problem\": \"mass\", \"answer\": \"a\"}"),
        std::string(100'000, '['), "{\"id\": " + std::string(200, '[')})
    EXPECT_TRUE(ask_text(request).contains("error")) << request.substr(0, 80);
  EXPECT_EQ(solve()["solution"]["status"], "converged");
}

}  // namespace
}  // namespace conddp
