#include "output/bench/best_known.hpp"

#include <fstream>

#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"

namespace conddp {
namespace {

class BestKnownFile : public ::testing::Test {
 protected:
  std::optional<BestKnown> load(const std::string& text) {
    std::ofstream(file_) << text;
    out_ = {};
    return load_best_known(file_, out_);
  }

  const TemporaryFolder folder_;
  const std::filesystem::path file_ = folder_ / "best_known.json";
  Diagnostics out_;
};

TEST_F(BestKnownFile, GivesCostsByTheHashOfTheirProblems) {
  const auto known = load(
      R"({"format": "conddp.best_known/1", "problems": {
            "one": {"problem_sha256": "aa", "cost": 1.5, "note": "what else there is"},
            "two": {"problem_sha256": "bb", "cost": -2}}})");
  ASSERT_TRUE(known) << format_diagnostics(out_, false);
  EXPECT_EQ(*known, (BestKnown{{"aa", 1.5}, {"bb", -2}}));
}

TEST_F(BestKnownFile, ReportsErrorsWithTheirPlaces) {
  const std::string format = R"({"format": "conddp.best_known/1", )";
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"{\n  \"format\": 1,,\n}", ":2:15: error: not valid JSON"},
      {R"({"format": "conddp.bench/1"})", "it is not a list of best known optima of conddp"},
      {R"({"format": "conddp.best_known/2"})", "this version reads format 1"},
      {format + R"("problem": {}})", "'problems' is missing"},
      {format + R"("problems": []})", "'problems' has no names"},
      {format + R"("problems": {"one": {"cost": 1}}})", "'problem_sha256' is missing ('one')"},
      {format + R"("problems": {"one": {"problem_sha256": "aa", "cost": "1"}}})",
       "'cost' is not a number ('one')"},
      {format + R"("problems": {"one": 3}})", "'problem_sha256' is missing ('one')"},
  };
  for (const auto& [text, message] : cases) {
    EXPECT_FALSE(load(text)) << text;
    const std::string said = format_diagnostics(out_, false);
    EXPECT_NE(said.find(message), std::string::npos) << said;
    EXPECT_NE(said.find(file_.string()), std::string::npos) << said;
  }
}

}  // namespace
}  // namespace conddp
