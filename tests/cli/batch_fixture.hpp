#pragma once

#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "process.hpp"

namespace conddp {

inline constexpr const char* kBatchSwing = R"(conddp: 1
system: {type: pendulum}
initial_state: {values: {theta: 0.1}}
phases: [{name: only, knots: 20, dt: 0.05}]
costs:
  effort: {residual: control, weight: 0.5}
constraints:
  torque: {bounds: control, lower: -2, upper: 2}
terminal:
  costs:
    goal: {residual: state, reference: {values: {theta: 1}}, weight: 10}
solver: {name: box_ddp}
)";

inline constexpr const char* kAxes = R"(vary:
  w: {key: costs.effort.weight, linspace: [0.2, 2, 6]}
  start: {perturb: initial_state, spread: 0.2, count: 5}
)";

/// Runs of `conddp batch` over a swing of a pendulum.
class Batch : public testing::Test {
 protected:
  using Words = std::vector<std::string>;

  Batch() { folder_.write("swing.yaml", kBatchSwing); }

  std::string plan(const std::string& rest = kAxes) const {
    return folder_.write("plan.yaml",
                         "conddp_batch: 1\nname: swings\nproblem: swing.yaml\n" + rest);
  }
  /// A fresh run folder of the plan.
  std::string planned(const std::string& name, const std::string& rest = kAxes) const {
    const std::string run = folder_.path() / name;
    const ProcessResult r = run_conddp({"batch", "plan", plan(rest), "-o", run});
    EXPECT_EQ(r.exit_code, 0) << r.err;
    return run;
  }
  static ProcessResult run(const std::string& run, const Words& options = {},
                           const ProcessOptions& process = {}) {
    Words words = {"batch", "run", run};
    words.insert(words.end(), options.begin(), options.end());
    return run_conddp(words, process);
  }
  static std::string collected(const std::string& run) {
    const ProcessResult r = run_conddp({"batch", "collect", run});
    EXPECT_EQ(r.exit_code, 0) << r.err;
    return read_file(std::filesystem::path(run) / "results.csv");
  }
  /// Results of the undisturbed run.
  std::string expected() const {
    const std::string folder = planned("undisturbed");
    const ProcessResult r = run(folder, {"-j", "1"});
    EXPECT_EQ(r.exit_code, 0) << r.err << r.out;
    return collected(folder);
  }
  /// Item ids in order.
  static Words ids(const std::string& run) {
    Words list;
    std::istringstream lines(read_file(std::filesystem::path(run) / "manifest.jsonl"));
    std::string line;
    std::getline(lines, line);
    while (std::getline(lines, line))
      list.push_back(nlohmann::json::parse(line).at("id").get<std::string>());
    return list;
  }

  TemporaryFolder folder_;
};

}  // namespace conddp
