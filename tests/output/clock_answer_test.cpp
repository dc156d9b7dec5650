// Trajectory tables whose states and controls are named like the time and the phase.
#include <sstream>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "output/solution/csv.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "support/solved_example.hpp"
#include "support/temporary_folder.hpp"

namespace conddp {
namespace {

const std::string kTail = R"(
phases: [{jump: {x: 2*x}}, {knots: 6, dt: 0.25}]
costs: {u: {residual: control}, x: {residual: expression, rows: x - 1}}
solver: {name: box_fddp}
)";
const std::string kFirstOrder = R"(conddp: 1
system: {states: [x], controls: [u], rate: {x: u + sin(t)}}
initial_state: {values: {x: 0.5, t: 2}})" +
                                kTail;
const std::string kSecondOrder = R"(conddp: 1
system: {positions: [x], velocities: [v], controls: [u], acceleration: {v: u + sin(t)}}
initial_state: {values: {x: 0.5}})" +
                                 kTail;
const std::string kTakenNames = R"(conddp: 1
system: {states: [x, phase], controls: [time], rate: {x: time, phase: x}}
initial_state: {values: {x: 0.5}})" +
                                kTail;
const std::string kDifferences = R"(conddp: 1
system: {states: [x, t], controls: [u], next: {x: x + u, t: t + 1}}
initial_state: {values: {x: 0.5}})" +
                                 kTail;

std::string table_of(const SolvedExample& answer) {
  return trajectory_csv(answer.built, answer.result->trajectory, {});
}
std::string header_of(const std::string& table) { return table.substr(0, table.find('\n')); }

/// Largest deviation of a problem's guess from the table of a motion.
double deviation_of_guess(const std::string& text, const std::string& table,
                          const Trajectory& motion) {
  const TemporaryFolder folder;
  const std::string file = folder.write("table.csv", table);
  Diagnostics out;
  const auto built = build_problem(read_problem_text(text, "text.yaml", {}, out),
                                   {.start = Located<std::filesystem::path>{file, {}}}, out);
  EXPECT_TRUE(built) << format_diagnostics(out, false);
  if (!built) return 1;
  double largest = 0;
  for (int k = 0; k < motion.knots(); ++k) {
    largest = std::max(largest, (built->guess.x(k + 1) - motion.x(k + 1)).norm());
    largest = std::max(largest, (built->guess.u(k) - motion.u(k)).norm());
  }
  return largest;
}

void expect_round_trip(const std::string& text, const std::string& header) {
  const SolvedExample answer{ProblemText{text}};
  const std::string table = table_of(answer);
  EXPECT_EQ(header_of(table), header);
  EXPECT_LT(deviation_of_guess(text, table, answer.result->trajectory), 1e-12) << table;
}

TEST(ClockAnswer, FirstOrderClockTableIsAGuess) {
  expect_round_trip(kFirstOrder, "t [s],phase,x,state/t [s],u");
}

TEST(ClockAnswer, SecondOrderClockTableIsAGuess) {
  expect_round_trip(kSecondOrder, "t [s],phase,x,state/t [s],v,t_rate [s/s],u");
}

TEST(ClockAnswer, TableWithTakenNamesIsAGuess) {
  expect_round_trip(kTakenNames, "t [s],phase,x,state/phase,u/time");
}

TEST(ClockAnswer, TableWithDifferenceTimeStateIsAGuess) {
  expect_round_trip(kDifferences, "t [s],phase,x,state/t,u");
}

TEST(ClockAnswer, TableNeedsNoClockColumn) {
  for (const std::string& text : {kFirstOrder, kSecondOrder}) {
    const SolvedExample answer{ProblemText{text}};
    const Trajectory& motion = answer.result->trajectory;
    std::string table = text == kFirstOrder ? "t,x,u\n" : "t,x,v,u\n";
    const std::vector<double> times = answer.built.problem->times(motion);
    for (int k = 1; k <= motion.knots(); ++k) {
      const double velocity = text == kFirstOrder ? 0 : motion.x(k)[2];
      table += fmt::format("{},{},", times[k], motion.x(k)[0]);
      if (text == kSecondOrder) table += fmt::format("{},", velocity);
      table += k < motion.knots() ? fmt::format("{}\n", motion.u(k)[0]) : "\n";
    }
    EXPECT_LT(deviation_of_guess(text, table, motion), 1e-12) << table;
  }
}

TEST(ClockAnswer, TableTimesAreNormalAtAnInitialJump) {
  const SolvedExample answer{ProblemText{kFirstOrder}};
  std::istringstream lines(table_of(answer));
  double before = -1;
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    const double time = std::stod(line);  // throws if a number is not normal
    EXPECT_GT(time, before);
    before = time;
  }
  EXPECT_EQ(before, 1.5);
}

}  // namespace
}  // namespace conddp
