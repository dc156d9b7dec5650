// Grid refinement, compared with exact answers of the collection.
#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "process.hpp"

namespace conddp {
namespace {

using Json = nlohmann::json;

struct MeshCase {
  const char* problem;
  const char* phase;
  double exact;
  double error;
  double tolerance;  ///< of the cost, relative
};

class Mesh : public ::testing::TestWithParam<MeshCase> {};

TEST_P(Mesh, RefinesUntilReplayAgreesAtTheExactCost) {
  const MeshCase& c = GetParam();
  const TemporaryFolder folder;
  const std::string file = source("problems/collection/" + std::string(c.problem) + ".yaml");
  const std::string knots = "phases." + std::string(c.phase) + ".knots=10";
  const ProcessResult solved =
      run_conddp({"solve", file, "--set", "integrator=rk2", "--set", knots, "--set",
                  "mesh={error: " + std::to_string(c.error) + "}", "-o", folder.path()});
  ASSERT_EQ(solved.exit_code, 0) << solved.out << solved.err;
  const std::string solution = folder.path() / "solution.json";
  const std::string text = read_file(solution);
  EXPECT_TRUE(fits_schema("solution", text));
  const Json document = Json::parse(text);
  const Json& mesh = document.at("mesh");
  EXPECT_LE(mesh.at("error").get<double>(), c.error);
  EXPECT_GT(mesh.at("rounds").size(), 1u);
  EXPECT_GT(mesh.at("rounds").front().at("error").get<double>(), c.error);
  EXPECT_EQ(mesh.at("rounds").back().at("knots"), document.at("problem").at("knots"));
  EXPECT_NEAR(document.at("cost").get<double>(), c.exact, c.tolerance * std::abs(c.exact));
  const ProcessResult verified = run_conddp({"verify", solution});
  EXPECT_EQ(verified.exit_code, 0) << verified.out << verified.err;
}

INSTANTIATE_TEST_SUITE_P(
    OfTheCollection, Mesh,
    ::testing::Values(MeshCase{"scalar_regulator", "only", 0.3807970779778824, 1e-5, 1e-4},
                      MeshCase{"oscillator_energy", "period", 0.15915494309189535, 1e-5, 1e-3},
                      MeshCase{"fermat", "ray", 2.3895264345742184, 1e-5, 1e-5},
                      MeshCase{"great_circle", "way", 1.26708182371641, 1e-5, 2e-5},
                      MeshCase{"driven_growth", "only", -0.256996962561, 1e-5, 2e-5}),
    [](const auto& tested) { return std::string(tested.param.problem); });

TEST(MeshLimits, FirstOrderStepsGetAdviceForHigherOrder) {
  const TemporaryFolder folder;
  const auto solve = [&](const std::string& integrator) {
    return run_conddp({"solve", source("problems/collection/scalar_regulator.yaml"), "--set",
                       "integrator=" + integrator, "--set", "phases.only.knots=5", "--set",
                       "mesh={error: 1.0e-12}", "-o", folder.path()})
        .out;
  };
  EXPECT_NE(solve("explicit_euler").find("; try an integrator of higher order"), std::string::npos);
  EXPECT_EQ(solve("rk2").find("; try an integrator of higher order"), std::string::npos);
}

TEST(MeshLimits, TooCoarseGridIsNotSuccess) {
  const TemporaryFolder folder;
  const ProcessResult result = run_conddp(
      {"solve", source("problems/collection/scalar_regulator.yaml"), "--set", "integrator=rk2",
       "--set", "phases.only.knots=5", "--set", "mesh={error: 1.0e-12}", "-o", folder.path()});
  EXPECT_EQ(result.exit_code, 1) << result.out << result.err;
  EXPECT_NE(result.out.find("more than 1.0e-12"), std::string::npos) << result.out;
  const std::string solution = folder.path() / "solution.json";
  const ProcessResult verified = run_conddp({"verify", solution});
  EXPECT_EQ(verified.exit_code, 0) << verified.out << verified.err;
  EXPECT_NE(verified.out.find("warning grid error "), std::string::npos) << verified.out;
  EXPECT_NE(verified.out.find(", more than 1.0e-12"), std::string::npos) << verified.out;
  const Json report = Json::parse(run_conddp({"verify", solution, "--json"}).out);
  const Json& warnings = report.at("certificate").at("warnings");
  ASSERT_FALSE(warnings.empty()) << report;
  EXPECT_NE(verified.out.find("warning " + warnings[0].get<std::string>() + "\n"),
            std::string::npos)
      << report;
}

TEST(MeshLimits, DetectsWrongRequestedError) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_conddp({"solve", source("problems/collection/scalar_regulator.yaml"), "--set",
                        "integrator=rk2", "--set", "phases.only.knots=5", "--set",
                        "mesh={error: 1.0e-12}", "-o", folder.path()})
                .exit_code,
            1);
  Json document = Json::parse(read_file(folder.path() / "solution.json"));
  for (const Json& asked : {Json(0.5), Json(), Json::array({1})}) {
    document["mesh"]["asked"] = asked;
    const std::string changed = folder.write("changed.json", document.dump());
    const ProcessResult verified = run_conddp({"verify", changed});
    EXPECT_EQ(verified.exit_code, 1) << verified.out << verified.err;
    EXPECT_EQ(verified.err.find("cannot be used"), std::string::npos) << verified.err;
    EXPECT_NE(verified.out.find("error asked of the grid"), std::string::npos) << verified.out;
  }
}

TEST(MeshLimits, AcceptsHonestAnswersWhoseReplayDiverges) {
  const TemporaryFolder folder;
  const std::string file = folder.write("runaway.yaml", R"(conddp: 1
system: {states: [x], controls: [u], rate: {x: x^3 + u}}
initial_state: {values: {x: 1}}
integrator: explicit_euler
mesh: {error: 1.0e-3}
phases: [{knots: 20, duration: 3}]
costs: {effort: {residual: control, weight: 0.001}, s: {residual: state, reference: [3]}}
solver: {name: altro}
)");
  EXPECT_EQ(run_conddp({"solve", file, "-o", folder.path()}).exit_code, 1);
  const std::string solution = folder.path() / "solution.json";
  ASSERT_TRUE(Json::parse(read_file(solution)).at("mesh").at("error").is_null());
  const ProcessResult verified = run_conddp({"verify", solution});
  EXPECT_EQ(verified.exit_code, 0) << verified.out << verified.err;
  EXPECT_NE(verified.out.find("warning grid error inf, more than 1.0e-03"), std::string::npos)
      << verified.out;
}

}  // namespace
}  // namespace conddp
