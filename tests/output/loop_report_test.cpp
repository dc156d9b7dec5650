// Data of the page of a closed loop.
#include "output/report/loop_report.hpp"

#include <sstream>

#include <fmt/format.h>

#include "base/files/text_file.hpp"
#include "loop_fixture.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

struct ReportedLoop : SimulatedLoop {
  explicit ReportedLoop(const std::string& text, const std::vector<std::string>& settings = {},
                        std::set<int> late = {})
      : SimulatedLoop(text, settings), recorder(*task) {
    if (!late.empty())
      task->mpc.controller.is_late = [late](int tick) { return late.contains(tick); };
    result = run_loop(*task, [this](const Mpc& mpc) { recorder.record(mpc); });
    data = loop_report(run(), recorder.plans());
  }
  const OrderedJson& plant() const { return data["solutions"][0]; }

  PlanRecorder recorder;
  OrderedJson data;
};

TEST(LoopReport, HasTheMotionOfThePlant) {
  const ReportedLoop loop(kBalancedCartpole);
  const OrderedJson& curves = loop.plant()["curves"];
  ASSERT_EQ(curves["t"].size(), loop.result.steps.size() + 1);
  EXPECT_EQ(curves["t"].back(), 1.5);
  EXPECT_EQ(curves["x"]["names"][1], "theta");
  EXPECT_NEAR(curves["x"]["values"][1][10].get<double>(), loop.result.steps[10].x[1], 1e-7);
  EXPECT_EQ(curves["u"]["values"][0].size(), loop.result.steps.size());
  EXPECT_EQ(curves["phases"].size(), 1u);
  const OrderedJson& scene = loop.plant()["scene"];
  EXPECT_EQ(scene["poses"].size(), 7 * scene["bodies"].size() * curves["t"].size());
}

/// The trot of the example problems in a short loop with this plant.
ReportedLoop trotting(const std::string& plant) {
  return ReportedLoop(
      read_text_file(source_tree() / "problems/quadruped_trot.yaml", 1 << 20).text,
      {"mpc={horizon: 0.4, tick: 0.02, duration: 0.3, repeat: gait, plant: " + plant + "}"});
}

/// Sum of the vertical forces at a row; counts open contacts.
double carried(const OrderedJson& forces, std::size_t row, int& open) {
  double sum = 0;
  open = 0;
  for (const auto& [name, rows] : forces.items())
    if (rows[row].is_null())
      ++open;
    else
      sum += rows[row][2].get<double>();
  return sum;
}

// 50 kg on four feet, and on two feet after 0.16 s.
TEST(LoopReport, HasTheContactForcesOfThePlant) {
  for (const char* plant : {"{dt: 0.002}", "{contacts: simulated, dt: 0.002}"}) {
    SCOPED_TRACE(plant);
    const ReportedLoop loop = trotting(plant);
    const OrderedJson& curves = loop.plant()["curves"];
    const OrderedJson& forces = curves["contact_forces"];
    ASSERT_EQ(forces.size(), 4u);
    for (const auto& [name, rows] : forces.items())
      ASSERT_EQ(rows.size(), loop.result.steps.size()) << name;
    int open = 0;
    EXPECT_NEAR(carried(forces, 40, open), 50 * 9.81, 75);
    EXPECT_EQ(open, 0);
    carried(forces, 120, open);
    EXPECT_EQ(open, 2);
    EXPECT_TRUE(forces["RF"][120].is_null());
  }
}

TEST(LoopReport, HasTheContactForcesOfItsTables) {
  const ReportedLoop loop = trotting("{contacts: simulated, dt: 0.002}");
  const std::string table = closed_loop_csv(loop.run());
  const std::string header = table.substr(0, table.find('\n'));
  EXPECT_TRUE(header.ends_with(",contact/RH/fx [N],contact/RH/fy [N],contact/RH/fz [N]")) << header;
  std::istringstream lines(table);
  std::string line;
  for (int i = 0; i <= 41; ++i) std::getline(lines, line);
  const double last_cell = std::stod(line.substr(line.rfind(',') + 1));
  EXPECT_NEAR(last_cell, loop.plant()["curves"]["contact_forces"]["RH"][40][2].get<double>(), 1e-4);
}

TEST(LoopReport, ShowsEachTicksPlanToItsHorizon) {
  const ReportedLoop loop(kBalancedCartpole);
  const OrderedJson& plans = loop.data["loop"]["plans"];
  ASSERT_EQ(plans["list"].size(), 75u);
  const OrderedJson& third = plans["list"][3];
  EXPECT_NEAR(third["from"].get<double>(), 0.06, 1e-9);
  EXPECT_NEAR(third["until"].get<double>(), 1.065, 1e-9);  // after the delay
  int nodes = 0;
  for (const OrderedJson& plan : plans["list"]) {
    EXPECT_EQ(plan["first"], nodes);
    nodes += plan["nodes"].get<int>();
  }
  const std::size_t bodies = loop.plant()["scene"]["bodies"].size();
  EXPECT_EQ(plans["poses"].size(), 7 * bodies * nodes);
  EXPECT_EQ(plans["track"].size(), 3u * nodes);
}

TEST(LoopReport, DrawsPlantAndPlansWithTheirControls) {
  const ReportedLoop loop(
      kBalancedCartpole,
      {"draw={push: {line: [[x, 0, 0], [x + force, 0, 0]]}, tip: {at: [x, force, 1]}}"});
  const OrderedJson& scene = loop.plant()["scene"];
  const OrderedJson& curves = loop.plant()["curves"];
  const OrderedJson& positions = scene["lines"][0]["positions"];
  const std::size_t bodies = scene["bodies"].size();
  for (const std::size_t k : {std::size_t{0}, std::size_t{10}, std::size_t{50}}) {
    const double force = curves["u"]["values"][0][k].get<double>();
    EXPECT_NEAR(positions[6 * k + 3].get<double>() - positions[6 * k].get<double>(), force, 1e-6);
    EXPECT_NEAR(scene["poses"][7 * bodies * (k + 1) - 6].get<double>(), force, 1e-6);
  }
  // The plan of the first tick begins with the control that the plant gets.
  const OrderedJson& plans = loop.data["loop"]["plans"];
  const auto node = plans["list"][1]["first"].get<std::size_t>();
  EXPECT_NE(plans["poses"][7 * bodies * (node + 1) - 6], 0.0);
}

TEST(LoopReport, HasNoPlanUnderTheFallback) {
  const ReportedLoop loop(kBalancedCartpole,
                          {"mpc.fallback={after: 2, to: {values: {theta: 3.141592653589793}}}"},
                          {20, 21, 22});
  const OrderedJson& list = loop.data["loop"]["plans"]["list"];
  EXPECT_GT(list[20]["nodes"], 0);
  EXPECT_EQ(list[21]["nodes"], 0);
  EXPECT_TRUE(list[22]["until"].is_null());
  EXPECT_GT(list[23]["nodes"], 0);
}

TEST(LoopReport, HasEventsOverTime) {
  const ReportedLoop loop(kBalancedCartpole,
                          {"mpc.fallback={after: 2, to: {values: {theta: 3.141592653589793}}}"},
                          {20, 21, 22});
  std::string events;
  for (const OrderedJson& event : loop.data["loop"]["events"])
    events += fmt::format("{} {:g}-{:g} {}; ", event["row"].get<std::string>(),
                          event["from"].get<double>(), event["to"].get<double>(),
                          event["text"].get<std::string>());
  EXPECT_EQ(events,
            "disturbances 1-1 jump; failed ticks 0.4-0.46 late, 3 ticks; fallback 0.42-0.46 "
            "fallback, 2 ticks; ");
  const ReportedLoop fallen(kBalancedCartpole, {"mpc.disturbances.0.jump.omega=20"});
  EXPECT_EQ(fallen.data["loop"]["events"].back()["text"], "stopped");
}

TEST(LoopReport, ThinsOutLoopsOfManySteps) {
  const ReportedLoop loop(kBalancedCartpole, {"mpc.duration=20"});
  EXPECT_GT(loop.result.steps.size(), 3900u);
  const OrderedJson& t = loop.plant()["curves"]["t"];
  EXPECT_LE(t.size(), 1500u);
  EXPECT_EQ(t.back(), 20);
  EXPECT_LE(loop.data["loop"]["plans"]["list"].size(), 300u);
  EXPECT_EQ(loop.data["loop"]["ticks"]["t"].size(), 1000u);
}

}  // namespace
}  // namespace conddp
