// Output and input of problems whose phases have different states and controls.
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "analysis/comparison/solution_comparison.hpp"
#include "ocp/problem/by_name.hpp"
#include "output/report/certificate_report.hpp"
#include "output/report/constraint_curves.hpp"
#include "output/report/report.hpp"
#include "output/solution/csv.hpp"
#include "output/solution/solution_json.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "support/solved_example.hpp"
#include "support/temporary_folder.hpp"

namespace conddp {
namespace {

namespace fs = std::filesystem;

/// The second system lists its controls in a different order than the columns.
const std::string kPhases = R"(conddp: 1
systems:
  first: {states: {x: m, v: m/s}, controls: {a: m/s^2, b: N}, rate: {x: v, v: a + 0.5*b}}
  second: {states: {x: m}, controls: {c: m/s, a: m/s^2}, rate: {x: c + a}}
initial_state: {values: {x: 1, v: 0.5}}
phases:
  - {name: first, system: first, knots: 3, duration: 1}
  - {name: hit, jump: {x: 0.5*x}}
  - {name: second, system: second, knots: 2, duration: 1}
costs: {effort: {residual: control}, near: {residual: state}}
constraints: {limits: {bounds: control, lower: {a: -0.2, c: -0.3}, upper: 2}}
terminal: {constraints: {end: {residual: state}}}
solver: {name: altro}
)";

const SolvedExample& answer() {
  static const SolvedExample solved(ProblemText{kPhases});
  return solved;
}

TEST(DifferentStatesAnswer, IsCertified) {
  ASSERT_EQ(answer().result->status, SolveStatus::converged) << answer().result->message;
  EXPECT_EQ(failures(answer().judge(answer().document)), "");
  const SolutionCertificate replayed = certify_solution(answer().document, answer().built, true);
  EXPECT_EQ(failures(replayed), "");
}

TEST(DifferentStatesAnswer, FailsIfAControlIsForged) {
  OrderedJson forged = answer().document;
  add_to(forged["trajectory"]["u"][4][2], 1e-3);  // c of the second phase
  EXPECT_NE(failures(answer().judge(forged)).find("[gap]"), std::string::npos);
}

TEST(DifferentStatesAnswer, HasAllControlColumnsWithNullWhereAbsent) {
  const OrderedJson& trajectory = answer().document["trajectory"];
  EXPECT_EQ(trajectory["columns"]["x"], OrderedJson({"x", "v"}));
  EXPECT_EQ(trajectory["columns"]["u"], OrderedJson({"a", "b", "c"}));
  const Trajectory& motion = answer().result->trajectory;
  EXPECT_EQ(trajectory["u"][0], OrderedJson({motion.u(0)[0], motion.u(0)[1], nullptr}));
  EXPECT_EQ(trajectory["u"][3], OrderedJson::array()) << "the jump";
  EXPECT_EQ(trajectory["u"][4], OrderedJson({motion.u(4)[1], nullptr, motion.u(4)[0]}));
  const OrderedJson& K = answer().document["gains"]["K"];
  EXPECT_TRUE(K[4][1][0].is_null());
  EXPECT_EQ(K[4][2][0], OrderedJson(answer().result->feedback.K[4](0, 0)));
}

TEST(DifferentStatesAnswer, HasEmptyTableCellsForAbsentControls) {
  std::istringstream csv(trajectory_csv(answer().built, answer().result->trajectory, {}));
  std::vector<std::string> lines;
  for (std::string line; std::getline(csv, line);) lines.push_back(line);
  ASSERT_EQ(lines.size(), 8u);
  EXPECT_EQ(lines[0], "t [s],phase,x [m],v [m/s],a [m/s^2],b [N],c [m/s]");
  EXPECT_TRUE(lines[1].ends_with(',')) << lines[1];
  EXPECT_NE(lines[5].find(",,"), std::string::npos) << lines[5];
  const double c = std::stod(lines[5].substr(lines[5].rfind(',') + 1));
  EXPECT_EQ(c, answer().result->trajectory.u(4)[0]);
  EXPECT_TRUE(lines[7].ends_with(",,,")) << lines[7];
}

TEST(DifferentStatesAnswer, AgreesWithItself) {
  const nlohmann::json document = nlohmann::json::parse(answer().document.dump());
  EXPECT_TRUE(compare_solutions(document, document).empty());
}

TEST(DifferentStatesAnswer, SurvivesARoundTrip) {
  const ShootingProblem& problem = *answer().built.problem;
  const Trajectory stored = stored_trajectory(answer().document, problem);
  const Trajectory& motion = answer().result->trajectory;
  for (int k = 0; k < problem.knots(); ++k) EXPECT_TRUE(stored.u(k) == motion.u(k)) << k;
}

/// The problem with an earlier solution as its guess.
BuiltProblem started_from(const std::string& solution) {
  Diagnostics out;
  const Place place{{out.add_source("start", solution), 1, 1}, "initial_guess"};
  auto built = build_problem(read_problem_text(kPhases, "text.yaml", {}, out),
                             {.start = Located<std::filesystem::path>{solution, place}}, out);
  EXPECT_TRUE(built) << format_diagnostics(out, false);
  return *std::move(built);
}

TEST(DifferentStatesAnswer, ServesAsAGuessWithMultipliers) {
  const TemporaryFolder folder;
  const fs::path json = folder / "solution.json", csv = folder / "trajectory.csv";
  std::ofstream(json) << answer().document.dump();
  const Trajectory& motion = answer().result->trajectory;
  std::ofstream(csv) << trajectory_csv(answer().built, motion, {});
  for (const fs::path& file : {json, csv}) {
    const BuiltProblem again = started_from(file.string());
    for (int k = 0; k < motion.knots(); ++k) {
      EXPECT_TRUE(again.guess.u(k) == motion.u(k)) << file << k;
      EXPECT_NEAR((again.guess.x(k) - motion.x(k)).norm(), 0, 1e-12) << file << k;
    }
  }
  const BuiltProblem again = started_from(json.string());
  EXPECT_EQ(again.guess_used.multipliers, "of the dynamics, end");
  ASSERT_TRUE(again.multipliers);
  const auto& gradient = again.multipliers->control_gradient;
  ASSERT_EQ(gradient.size(), 6u);
  ASSERT_EQ(gradient[4].size(), 2);
  // c is at its bound; its column is the last.
  EXPECT_GT(gradient[4][0], 0);
  EXPECT_EQ(gradient[4][0], answer().document["multipliers"]["control_lower"][4][2].get<double>());
}

TEST(DifferentStatesAnswer, HasBoundsUnderTheirColumnsInReports) {
  const OrderedJson data =
      report_data(std::vector<ReportEntry>{{"answer", answer().document, &answer().built}});
  const OrderedJson& u = data["solutions"][0]["curves"]["u"];
  EXPECT_EQ(u["names"], OrderedJson({"a", "b", "c"}));
  EXPECT_EQ(u["lower"][0], OrderedJson({-0.2, -0.2, -0.2, nullptr, -0.2, -0.2}));
  EXPECT_EQ(u["lower"][2], OrderedJson({nullptr, nullptr, nullptr, nullptr, -0.3, -0.3}));
  EXPECT_EQ(u["upper"][1], OrderedJson({2.0, 2.0, 2.0, nullptr, nullptr, nullptr}));
}

TEST(DifferentStatesAnswer, BoundOnChangingStatesHasAMargin) {
  std::string text = kPhases;
  text.replace(text.find("limits: {"), 9, "room: {bounds: state, lower: -9}, limits: {");
  const SolvedExample bounded(ProblemText{text});
  const OrderedJson curves = constraint_curves(bounded.built, bounded.result->trajectory);
  ASSERT_EQ(curves[0]["name"], "room");
  EXPECT_TRUE(curves[0]["margin"].get<bool>());
  const Trajectory& motion = bounded.result->trajectory;
  EXPECT_NEAR(curves[0]["rows"][0]["values"].back().get<double>(), 9 + motion.x(5)[0], 1e-6);
}

TEST(DifferentStatesAnswer, ColumnsFollowTheOrderOfPhases) {
  const ControlColumns columns(*answer().built.problem);
  ASSERT_EQ(columns.count(), 3);
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(columns.columns()[i].name, answer().built.control_columns[i].name);
  EXPECT_TRUE(columns.are_some(0));
  EXPECT_FALSE(columns.are_some(3)) << "the jump";
  const std::span<const int> second = columns.columns_of(4);
  EXPECT_EQ(std::vector<int>(second.begin(), second.end()), (std::vector<int>{2, 0}));
}

}  // namespace
}  // namespace conddp
