#include <cmath>
#include <map>
#include <sstream>

#include <gtest/gtest.h>

#include "base/files/check_sums.hpp"
#include "output/solution/csv.hpp"
#include "output/solution/solution_json.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/data/data_table.hpp"
#include "problem_file/expand/expand_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "spatial/lane.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

constexpr const char* kProblem = R"(conddp: 1
name: small
system: {type: double_integrator, dimension: 2}
initial_state: {state: [1, 0, 0, 0]}
phases: [{name: a, knots: 3, dt: 0.1}, {name: "b,c", knots: 2, dt: 0.2}]
costs: {effort: {residual: control}}
constraints: {limit: {bounds: control, lower: [-1, null], upper: 1}}
terminal: {costs: {goal: {residual: state, weight: 10}}}
solver: {name: box_ddp}
)";

std::string csv_of(const Solution& s) {
  return trajectory_csv(s.built, s.result.trajectory, s.answer.forces);
}

class SolutionOutput : public testing::Test {
 protected:
  SolutionOutput() {
    Diagnostics out;
    spec_ = *read_problem_text(kProblem, "folder/small.yaml", {}, out);
    built_ = *build_problem(spec_, {}, out);
    result_ = std::make_unique<SolveResult>(
        solve(*built_.problem, "box_ddp", spec_.solver.options, built_.guess));
  }
  Solution solution() const {
    return {built_, *find_solver("box_ddp"), *result_, {"solver.name=box_ddp"}};
  }
  ProblemSpec spec_;
  BuiltProblem built_;
  std::unique_ptr<SolveResult> result_;
};

TEST_F(SolutionOutput, JsonHasTheShapesOfTheProblem) {
  const OrderedJson json = solution_json(solution());
  EXPECT_EQ(json["format"], "conddp.solution/1");
  EXPECT_EQ(json["problem"]["sha256"], sha256(kProblem));
  EXPECT_EQ(json["status"], "converged");
  EXPECT_EQ(json["cost_by_name"].size(), 2u);
  EXPECT_EQ(json["trajectory"]["t"].size(), 6u);
  EXPECT_EQ(json["trajectory"]["x"].size(), 6u);
  EXPECT_EQ(json["trajectory"]["u"].size(), 5u);
  EXPECT_EQ(json["trajectory"]["columns"]["x"].size(), 4u);
  EXPECT_EQ(json["trajectory"]["phases"][1]["first_knot"], 3);
  EXPECT_EQ(json["gains"]["K"].size(), 5u);
  EXPECT_EQ(json["gains"]["K"][0].size(), 2u);
  EXPECT_EQ(json["gains"]["K"][0][0].size(), 4u);
  EXPECT_EQ(json["multipliers"]["costates"].size(), 6u);
  EXPECT_EQ(json["log"].size(), result_->log.size());
  EXPECT_EQ(json["problem"]["overrides"][0], "solver.name=box_ddp");
}

TEST_F(SolutionOutput, JsonNumbersSurviveTheText) {
  const OrderedJson json = OrderedJson::parse(json_text(solution_json(solution())));
  for (int k = 0; k <= 5; ++k)
    for (int i = 0; i < 4; ++i)
      EXPECT_EQ(json["trajectory"]["x"][k][i].get<double>(), result_->trajectory.x(k)[i]);
}

TEST_F(SolutionOutput, RecordsItsInputs) {
  const OrderedJson problem = solution_json(solution())["problem"];
  EXPECT_EQ(problem["configuration"], expand_problem(built_));
  EXPECT_EQ(problem["configuration"]["solver"]["tolerances"], problem["options"]["tolerances"]);
  EXPECT_EQ(problem["robots"], OrderedJson::array());
  EXPECT_EQ(problem["data_files"], OrderedJson::array());
  const OrderedJson tool = solution_json(solution())["tool"];
  EXPECT_EQ(tool["build"]["lane_width"], kLaneWidth);
  EXPECT_FALSE(tool["build"]["compiler"].get<std::string>().empty());
  EXPECT_GE(tool["libraries"].size(), 5u);
}

TEST_F(SolutionOutput, NonFiniteNumbersAreNullWithAReason) {
  result_->cost = std::nan("");
  result_->residuals.stationarity = INFINITY;
  result_->status = SolveStatus::diverged;
  result_->message = "the cost of knot 3 is not finite";
  const OrderedJson json = solution_json(solution());
  std::map<std::string, std::string> reasons;
  for (const auto& entry : json["nulls"]) reasons[entry["key"]] = entry["reason"];
  EXPECT_EQ(reasons["problem.options.max_time_s"], "without limit");
  EXPECT_EQ(reasons["cost"],
            "not finite, or not evaluated because the solve ended as 'diverged': the cost of knot "
            "3 is not finite");
  EXPECT_TRUE(reasons.contains("residuals"));
  EXPECT_FALSE(reasons.contains("trajectory.x"));
  EXPECT_EQ(solution_head(solution())["nulls"][1]["key"], "cost");
  EXPECT_TRUE(json["cost"].is_null());
  EXPECT_TRUE(json["residuals"]["stationarity"].is_null());
  EXPECT_TRUE(json["problem"]["options"]["max_time_s"].is_null());
}

TEST_F(SolutionOutput, CsvHasUniqueHeadersAndIncreasingTime) {
  const std::string text = csv_of(solution());
  Diagnostics out;
  const auto table = parse_csv(text, "trajectory.csv", out);
  ASSERT_TRUE(table) << format_diagnostics(out, false);
  EXPECT_EQ(table->rows.size(), 6u);
  EXPECT_EQ(table->columns.size(), 6u);
  EXPECT_FALSE(table->rows[5][4]);  // no control at the last node
  EXPECT_EQ(*table->rows[2][1], result_->trajectory.x(2)[1]);
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);
  EXPECT_TRUE(line.starts_with("t [s],phase,")) << line;
  for (int k = 0; k < 4; ++k) std::getline(lines, line);
  EXPECT_NE(line.find(",b_c,"), std::string::npos) << line;  // no commas inside cells
}

TEST_F(SolutionOutput, IterationsHaveOneRowEach) {
  const std::string text = iterations_csv(solution_json(solution())["log"]);
  EXPECT_EQ(static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')),
            result_->log.size() + 1);
  EXPECT_TRUE(text.starts_with("iteration,cost,merit,stationarity,"));
}

TEST_F(SolutionOutput, SolutionReadsBackAsATable) {
  Diagnostics out;
  const auto table = parse_solution(json_text(solution_json(solution())), "solution.json", out);
  ASSERT_TRUE(table) << format_diagnostics(out, false);
  EXPECT_EQ(table->times, built_.problem->times());
  EXPECT_EQ(*table->rows[1][4], result_->trajectory.u(1)[0]);
}

TEST(ContactOutput, PushesStandingFeetAndOmitsAirborneOnes) {
  Diagnostics out;
  const auto spec = read_problem(source_tree() / "problems/hopper_jump.yaml", {}, out);
  ASSERT_TRUE(spec) << format_diagnostics(out, false);
  const auto built = build_problem(*spec, {}, out);
  ASSERT_TRUE(built) << format_diagnostics(out, false);
  const SolveResult guess = solve(*built->problem, "box_fddp", {.max_iterations = 0}, built->guess);
  const Solution solution{*built, *find_solver("box_fddp"), guess, {}};
  const OrderedJson trajectory = solution_json(solution)["trajectory"];
  const OrderedJson& foot = trajectory["contact_forces"]["foot"];
  std::istringstream csv(csv_of(solution));
  std::string line;
  std::getline(csv, line);
  EXPECT_NE(line.find(",contact/foot/fx [N],contact/foot/fy [N],contact/foot/fz [N]"), line.npos)
      << line;
  for (const OrderedJson& phase : trajectory["phases"]) {
    const std::string name = phase["name"];
    for (int k = 0; k < phase["knots"]; ++k) {
      const OrderedJson& force = foot[phase["first_knot"].get<int>() + k];
      std::getline(csv, line);
      EXPECT_EQ(force.is_null(), name == "flight") << name;
      EXPECT_EQ(line.ends_with(",,,"), name == "flight" || name == "touch_down") << line;
      EXPECT_TRUE(name != "push" || force[2] > 10) << line;
    }
  }
}

/// The motion begins with the chosen state; the JSON document records the choice.
TEST(ChosenStartOutput, CsvFileBeginsWithTheChosenState) {
  Diagnostics out;
  const auto spec = read_problem(source_tree() / "problems/pendulum_cycle.yaml", {}, out);
  ASSERT_TRUE(spec) << format_diagnostics(out, false);
  const auto built = build_problem(*spec, {}, out);
  ASSERT_TRUE(built) << format_diagnostics(out, false);
  Trajectory guess = built->guess;
  guess.u(0) << 0.3, -0.7;
  Evaluator(*built->problem).simulate(guess);
  const SolveResult result = solve(*built->problem, "altro", {.max_iterations = 0}, guess);
  const Solution solution{*built, *find_solver("altro"), result, {}};
  const auto table = parse_csv(csv_of(solution), "trajectory.csv", out);
  ASSERT_TRUE(table) << format_diagnostics(out, false);
  EXPECT_EQ(table->columns, (std::vector<std::string>{"theta", "omega", "torque"}));
  ASSERT_EQ(table->rows.size(), 101u);
  EXPECT_EQ(table->times[0], 0);
  EXPECT_EQ(table->times[1], 0.02);
  EXPECT_EQ(*table->rows[0][0], 0.3);
  EXPECT_EQ(*table->rows[0][1], -0.7);

  const OrderedJson trajectory = solution_json(solution)["trajectory"];
  EXPECT_EQ(trajectory["u"][0], OrderedJson({0.3, -0.7}));
  EXPECT_EQ(trajectory["x"][1], OrderedJson({0.3, -0.7, 0.3, -0.7}));
  const auto former = parse_solution(json_text(solution_json(solution)), "solution.json", out);
  ASSERT_TRUE(former) << format_diagnostics(out, false);
  // Follows the given state at the same time.
  EXPECT_EQ(std::vector(former->times.begin() + 1, former->times.end()), table->times);
  EXPECT_EQ(former->times[0], 0);
  EXPECT_EQ(*former->rows[1][1], -0.7);
}

TEST(JsonText, KeepsRowsOnOneLine) {
  const OrderedJson json = {
      {"a", {1, 2.5, nullptr}}, {"m", {{1, 2}, {3, 4}}}, {"e", OrderedJson::array()}};
  EXPECT_EQ(json_text(json),
            "{\n  \"a\": [1,2.5,null],\n  \"m\": [\n    [1,2],\n    [3,4]\n  ],\n  \"e\": []\n}\n");
}

}  // namespace
}  // namespace conddp
