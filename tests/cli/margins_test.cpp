// Noise that plans withstand.
#include <map>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "process.hpp"

namespace conddp {
namespace {

using Json = nlohmann::json;

const std::string kLimits = source("problems/double_integrator_limits.yaml");

TEST(Margins, ListTheClosestBoundFirst) {
  const ProcessResult result =
      run_conddp({"margins", kLimits, "--initial", "0.01", "--process", "{\"v*\": 0.005}"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  for (const char* words :
       {"double_integrator_limits\n", "  initial     0.01 each\n", "  process     v/0 0.005\n",
        "  measurement none\n", "smallest margin", "speed  upper"})
    EXPECT_NE(result.out.find(words), std::string::npos) << words << '\n' << result.out;
}

TEST(Margins, ShrinkWithMoreNoise) {
  const auto margins = [](const char* sigma) {
    const ProcessResult result = run_conddp({"margins", kLimits, "--measurement", sigma, "--json"});
    EXPECT_TRUE(fits_schema("margins", result.out)) << result.out;
    std::map<std::string, double> found;
    const Json document = Json::parse(result.out);
    for (const Json& bound : document["bounds"])
      found[bound["name"].get<std::string>() + ' ' + bound["side"].get<std::string>()] =
          bound["smallest"]["margin"];
    return found;
  };
  const auto some = margins("0.01"), twice = margins("0.02");
  ASSERT_TRUE(some.contains("u/0 lower"));
  EXPECT_NEAR(twice.at("u/0 lower"), some.at("u/0 lower") / 2, 1e-9 * some.at("u/0 lower"));
}

TEST(Margins, RejectsNoiseThatIsTooLarge) {
  const ProcessResult result = run_conddp({"margins", kLimits, "--initial", "1e155"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.err.find("the noise is too large"), std::string::npos) << result.err;
  EXPECT_EQ(result.out, "");
}

TEST(Margins, WarnsAboutPlansThatAreNotSolutions) {
  const ProcessResult result =
      run_conddp({"margins", kLimits, "--process", "0.01", "--set", "solver.max_iterations=1"});
  EXPECT_EQ(result.exit_code, 1) << result.err;
  EXPECT_NE(result.err.find("warning: the plan is not a solution"), std::string::npos)
      << result.err;
}

}  // namespace
}  // namespace conddp
