#include "problem_file/data/dual_guess_reader.hpp"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "problem_text.hpp"
#include "support/temporary_folder.hpp"

namespace conddp {
namespace {

/// The small pendulum with a speed bound and a terminal constraint.
std::string problem_text(int knots = 4, const char* speed = "speed") {
  std::string text = replaced(kPendulum, "name: box_ddp", "name: altro");
  text = replaced(text, "knots: 4", "knots: " + std::to_string(knots));
  text = replaced(text, "constraints:\n",
                  std::string("constraints:\n  ") + speed + ": {bounds: velocity, upper: 5}\n");
  return replaced(text, "terminal:\n",
                  "terminal:\n  constraints: {end: {residual: state, columns: theta}}\n");
}

/// A solution of problem_text() with multipliers that identify their places.
std::string solution_text(double first = 1) {
  std::string costates, constraints, controls;
  for (int k = 0; k <= 10; ++k) costates += (k > 0 ? ",[" : "[") + std::to_string(k) + ",0.5]";
  for (int k = 0; k < 10; ++k) controls += k > 0 ? ",[0.25]" : "[0.25]";
  for (int k = 1; k <= 10; ++k)
    constraints += "{\"name\":\"speed\",\"node\":" + std::to_string(k) + ",\"multiplier\":[" +
                   std::to_string(k == 1 ? first : k) + "]},";
  constraints += "{\"name\":\"end\",\"node\":10,\"multiplier\":[-7]}";
  return "{\"format\":\"conddp.solution/1\",\"multipliers\":{\"costates\":[" + costates +
         "],\"control_lower\":[" + controls + "],\"control_upper\":[" + controls +
         "],\"constraints\":[" + constraints + "]}}";
}

class DualGuessReader : public ::testing::Test {
 protected:
  std::optional<DualGuessUsed> read(const std::string& solution, const std::string& problem) {
    std::ofstream(file_) << solution;
    loaded_ = std::make_unique<Loaded>(problem);
    EXPECT_TRUE(loaded_->built) << loaded_->all();
    return read_dual_guess(file_, {}, *loaded_->built->problem, out_);
  }
  double multiplier(const DualGuess& guess, const std::string& name, int node) const {
    for (const NodeConstraint& c : loaded_->built->problem->constraints())
      if (c.term->name == name && c.node == node) return guess.constraints[c.row];
    return -99;
  }

  const TemporaryFolder folder_;
  const std::filesystem::path file_ = folder_ / "solution.json";
  std::unique_ptr<Loaded> loaded_;
  Diagnostics out_;
};

TEST_F(DualGuessReader, ReadsMultipliersOfTheSameProblem) {
  const auto used = read(solution_text(), problem_text());
  ASSERT_TRUE(used && used->guess) << format_diagnostics(out_, false);
  EXPECT_EQ(multiplier(*used->guess, "speed", 3), 3);
  EXPECT_EQ(multiplier(*used->guess, "end", 10), -7);
  EXPECT_EQ(used->guess->costates(0, 4), 4);
  ASSERT_EQ(used->guess->control_gradient.size(), 10u);
  EXPECT_EQ(used->guess->control_gradient[2][0], 0) << "the lower bound's minus the upper one's";
  EXPECT_EQ(used->text, "of the dynamics, speed, end");
}

TEST_F(DualGuessReader, OmitsChangedConstraintsByName) {
  const auto renamed = read(solution_text(), problem_text(4, "swiftness"));
  ASSERT_TRUE(renamed && renamed->guess);
  EXPECT_EQ(multiplier(*renamed->guess, "swiftness", 3), 0);
  EXPECT_EQ(multiplier(*renamed->guess, "end", 10), -7);
  EXPECT_NE(renamed->text.find("not of swiftness"), std::string::npos) << renamed->text;
}

TEST_F(DualGuessReader, IgnoresOtherGrids) {
  const auto longer = read(solution_text(), problem_text(5));
  ASSERT_TRUE(longer);
  EXPECT_FALSE(longer->guess);
  EXPECT_NE(longer->text.find("none; not of speed, end"), std::string::npos) << longer->text;
}

TEST_F(DualGuessReader, ReportsFilesThatAreNotSolutions) {
  EXPECT_FALSE(read("{\"format\":\"conddp.solution/1\"}", problem_text()));
  EXPECT_TRUE(out_.has_errors());
}

}  // namespace
}  // namespace conddp
