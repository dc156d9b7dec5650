// Outputs appear completely or not at all, whatever happens during writing.
#include <chrono>
#include <csignal>
#include <map>

#include <sys/stat.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "process.hpp"

namespace conddp {
namespace {

using Json = nlohmann::json;
using Contents = std::map<std::string, std::string>;

const std::vector<std::string> kNames = {"iterations.csv", "solution.json", "trajectory.csv"};

Contents contents(const std::filesystem::path& folder) {
  Contents found;
  for (const std::string& name : kNames) found[name] = read_file(folder / name);
  return found;
}

/// A folder with the output of an earlier run, and the arguments of a run with a different answer.
class WholeOrNothing : public testing::Test {
 protected:
  WholeOrNothing() {
    EXPECT_EQ(run_conddp({"solve", kPendulum, "-o", out_}).exit_code, 0);
    former_ = contents(out_);
  }
  void expect_former_output() const {
    EXPECT_EQ(folder_.files(), (std::vector<std::string>{"out/iterations.csv", "out/solution.json",
                                                         "out/trajectory.csv"}));
    EXPECT_EQ(contents(out_), former_);
  }

  TemporaryFolder folder_;
  std::filesystem::path out_ = folder_.path() / "out";
  std::vector<std::string> other_ = {"solve", kPendulum, "-o", out_, "--solver", "ilqr_clip"};
  Contents former_;
};

TEST_F(WholeOrNothing, FullDiskKeepsTheFormerOutput) {
  std::size_t largest = 0;
  for (const auto& [name, text] : former_) largest = std::max(largest, text.size());
  for (const double part : {0.0, 0.05, 0.3, 0.6, 0.9}) {
    const int limit = static_cast<int>(part * static_cast<double>(largest));
    const ProcessResult r = run_conddp(other_, {.limit_file_size = limit});
    EXPECT_EQ(r.exit_code, 2) << limit;
    EXPECT_EQ(r.out, "");
    EXPECT_NE(r.err.find("cannot be written"), std::string::npos) << r.err;
    expect_former_output();
  }
}

TEST_F(WholeOrNothing, FailedReplacementLeavesAllFilesUnchanged) {
  for (const std::string& name : kNames) {
    const std::string text = former_[name];
    std::filesystem::remove(out_ / name);
    std::filesystem::create_directory(out_ / name);
    const ProcessResult r = run_conddp(other_);
    EXPECT_EQ(r.exit_code, 2);
    EXPECT_NE(r.err.find(name + "' cannot be written"), std::string::npos) << r.err;
    std::filesystem::remove(out_ / name);
    folder_.write("out/" + name, text);
    expect_former_output();
  }
}

TEST_F(WholeOrNothing, FailedReportReplacementKeepsTheFormerOutput) {
  std::filesystem::create_directory(out_ / "report.html");
  std::vector<std::string> with_report = other_;
  with_report.push_back("--report");
  const ProcessResult r = run_conddp(with_report);
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("report"), std::string::npos) << r.err;
  std::filesystem::remove(out_ / "report.html");
  expect_former_output();
}

TEST_F(WholeOrNothing, KeepsReadOnlyFolders) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  chmod(out_.c_str(), 0555);
  const ProcessResult r = run_conddp(other_);
  chmod(out_.c_str(), 0755);
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("cannot be written"), std::string::npos) << r.err;
  expect_former_output();
}

TEST_F(WholeOrNothing, NamesFoldersThatAreNotWritable) {
  const ProcessResult r = run_conddp({"solve", kPendulum, "-o", "/proc/self"});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("cannot be written"), std::string::npos) << r.err;
}

TEST_F(WholeOrNothing, KillAtAnyMomentLeavesWholeFiles) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  const TemporaryFolder apart;
  std::vector<std::string> elsewhere = other_;
  elsewhere[3] = apart.path();
  EXPECT_EQ(run_conddp(elsewhere).exit_code, 1);  // a baseline that does not converge
  const Contents latter = contents(apart.path());
  const auto whole = std::chrono::duration_cast<std::chrono::microseconds>(Clock::now() - start);
  constexpr int kKills = 40;
  for (int i = 0; i < kKills; ++i) {
    const auto delay = whole * (i + 1) / kKills;
    run_conddp(other_, {.kill_after_us = static_cast<int>(delay.count())});
    for (const std::string& name : kNames) {
      const std::string text = read_file(out_ / name);
      if (name == "solution.json") {
        EXPECT_FALSE(Json::parse(text, nullptr, false).is_discarded());
        EXPECT_EQ(Json::parse(text)["trajectory"].empty(), false);
      } else if (name == "trajectory.csv") {
        EXPECT_TRUE(text == former_[name] || text == latter.at(name)) << delay.count();
      } else {
        EXPECT_EQ(text.back(), '\n');
      }
    }
  }
  // The next run removes leftovers of killed runs.
  EXPECT_EQ(run_conddp(other_).exit_code, 1);
  EXPECT_EQ(folder_.files().size(), kNames.size());
}

}  // namespace
}  // namespace conddp
