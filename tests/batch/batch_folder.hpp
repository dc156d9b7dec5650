#pragma once

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "batch/plan/batch_plan.hpp"
#include "batch/plan/expand_plan.hpp"
#include "support/temporary_folder.hpp"

namespace conddp {

inline constexpr const char* kSwing = R"(conddp: 1
system: {type: pendulum}
initial_state: {values: {theta: 0.1}}
phases:
  - {name: first, knots: 4, dt: 0.1}
  - {name: second, knots: 6, dt: 0.05}
costs:
  effort: {residual: control, weight: 0.5}
terminal:
  costs:
    goal: {residual: state, reference: {values: {theta: 1}}, weight: 10}
solver: {name: ilqr}
)";

/// A plan over the problem `kSwing`, read and expanded.
struct PlannedBatch {
  explicit PlannedBatch(const std::string& rest, const std::string& problem = kSwing) {
    folder.write("swing.yaml", problem);
    file = folder.write("plan.yaml", "conddp_batch: 1\nproblem: swing.yaml\n" + rest);
    plan_again();
  }
  void plan_again() {
    diagnostics = Diagnostics();
    plan = load_batch_plan(file, diagnostics);
    manifest = plan ? expand_plan(*plan, folder.path() / "run", diagnostics) : std::nullopt;
  }
  /// "plan.yaml:line:column: message" of the first error.
  std::string error() const {
    for (const Diagnostic& d : diagnostics.list())
      if (d.severity == Severity::kError)
        return std::filesystem::path(d.file).filename().string() + ":" + std::to_string(d.line) +
               ":" + std::to_string(d.column) + ": " + d.message;
    return {};
  }

  TemporaryFolder folder;
  std::filesystem::path file;
  Diagnostics diagnostics;
  std::optional<BatchPlan> plan;
  std::optional<Manifest> manifest;
};

}  // namespace conddp
