// The key draw.
#include <gtest/gtest.h>

#include "problem_file/expand/expand_problem.hpp"
#include "problem_text.hpp"

namespace conddp {
namespace {

std::string drawing(const std::string& draw) { return std::string(kPendulum) + "draw: " + draw; }

/// The first error of a file with this drawing `d`, and its hint.
std::string defect(const std::string& keys) {
  const Loaded loaded(drawing("{d: {" + keys + "}}\n"));
  const Diagnostic* error = loaded.error();
  return error ? fmt::format("{}:{}: {} ({})", error->line, error->column, error->message,
                             error->hint)
               : "";
}

TEST(Drawing, MayUseConstantsControlsAndKinks) {
  const Loaded loaded(
      drawing("{rod: {line: [[0, 0], ['sin(theta)', '-abs(torque)']]}, wall: {box: {size: [1, 1, "
              "1]}}, bob: {at: [0, 1, 'min(t, 1)'], angle: theta}}\n"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_TRUE(loaded.diagnostics.list().empty()) << loaded.all();
  EXPECT_TRUE(loaded.built->drawn);
  EXPECT_EQ(loaded.built->problem->constraints().size(), 0u);
}

TEST(Drawing, DoesNotChangeTheProblem) {
  const Loaded bare{std::string(kPendulum)}, drawn(drawing("{bob: {at: [theta, omega]}}\n"));
  ASSERT_TRUE(bare.built && drawn.built) << drawn.all();
  EXPECT_FALSE(bare.built->drawn);
  EXPECT_EQ(problem_sha256(*bare.built), problem_sha256(*drawn.built));
}

TEST(Drawing, NamesUnknownNamesAtTheirPlace) {
  EXPECT_EQ(defect("at: [theta, thta]").substr(0, 28), "17:24: unknown name 'thta' (");
  EXPECT_NE(defect("at: [theta, thta]").find("theta"), std::string::npos);
}

TEST(Drawing, ChecksNumbersOfExpressions) {
  EXPECT_EQ(defect("at: [theta]"),
            "17:16: this has 1 number (a place is [x, y], [x, y, z] or, with a quaternion, [x, y, "
            "z, q])");
  EXPECT_EQ(defect("at: [0, 0], angle: [theta, 0]"),
            "17:31: this has 2 numbers (an angle is one number, rad)");
  EXPECT_EQ(defect("line: [[0, 0], theta]"),
            "17:27: this has 1 number (a corner is [x, y] or [x, y, z])");
}

TEST(Drawing, ReportsContradictoryKeys) {
  EXPECT_EQ(defect(""),
            "17:11: nothing is drawn (give a shape ('box', ...), a place 'at: [x, y]' "
            "or a 'line')");
  EXPECT_NE(defect("line: [[0, 0], [theta, 1]], at: [0, 0]").find("'line'"), std::string::npos);
  EXPECT_NE(defect("sphere: {radius: 1}, box: {size: [1, 1, 1]}").find("'box'"), std::string::npos);
  EXPECT_NE(defect("sphere: {radius: 1}, angle: theta").find("'angle' needs 'at'"),
            std::string::npos);
  EXPECT_NE(defect("line: [[0, 0]]").find("a line has two corners or more"), std::string::npos);
}

TEST(Drawing, IsExpandedAsWritten) {
  const Loaded loaded(drawing("{bob: {sphere: {radius: 0.1}, at: ['sin(theta)', 0]}}\n"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const std::string text = expand_problem(*loaded.built).dump();
  EXPECT_NE(text.find(R"("at":"[sin(theta), 0]")"), std::string::npos) << text;
}

}  // namespace
}  // namespace conddp
