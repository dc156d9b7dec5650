#pragma once

#include <fstream>
#include <sstream>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "problem_file/assemble/build.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "support/source_tree.hpp"

namespace conddp {

inline const std::filesystem::path kProblems = source_tree() / "problems";

/// A small correct problem; tests replace or append lines.
inline constexpr std::string_view kPendulum = R"(conddp: 1
name: test
system: {type: pendulum}
initial_state: {values: {theta: 0.1}}
integrator: rk4
phases:
  - {name: first, knots: 4, dt: 0.1}
  - {name: second, knots: 6, dt: 0.05}
costs:
  effort: {residual: control, weight: 0.5}
constraints:
  torque: {bounds: control, lower: -3, upper: 3}
terminal:
  costs:
    goal: {residual: state, reference: {values: {theta: 1}}, weight: 10}
solver: {name: box_ddp}
)";

inline constexpr std::string_view kCartpole = R"(conddp: 1
robot:
  urdf: robots/cartpole.urdf
  actuation: {joints: [slider]}
  configurations:
    up: {joints: {hinge: 3}}
initial_state: {configuration: up}
phases: [{name: only, knots: 5, dt: 0.1}]
)";

/// Beginning of problems of a quadruped standing on four feet.
inline const std::string kStandingQuadruped = R"(conddp: 1
robot: {urdf: robots/quadruped.urdf, base: floating}
contacts:
  LF: {frame: lf_foot}
  RF: {frame: rf_foot}
  LH: {frame: lh_foot}
  RH: {frame: rh_foot}
initial_state:
  base: {position: [0, 0, 0.57]}
  joints: {LF_HFE: 0.75, LF_KFE: -1.5, RF_HFE: 0.75, RF_KFE: -1.5,
           LH_HFE: -0.75, LH_KFE: 1.5, RH_HFE: -0.75, RH_KFE: 1.5}
)";

/// The text with the first occurrence of `from` replaced; `from` must occur.
inline std::string replaced(std::string_view text, std::string_view from, std::string_view to) {
  std::string result(text);
  const std::size_t at = result.find(from);
  EXPECT_NE(at, std::string::npos) << "no '" << from << "' in the text";
  if (at != std::string::npos) result.replace(at, from.size(), to);
  return result;
}

/// A problem that was read and, if `spec` is valid, built; relative paths refer to problems/.
struct Loaded {
  explicit Loaded(const std::string& text, const std::vector<std::string>& settings = {},
                  const BuildOptions& options = {}) {
    spec = read_problem_text(text, kProblems / "test.yaml", settings, diagnostics);
    if (spec) built = build_problem(*spec, options, diagnostics);
  }
  /// "line:column: message" of the first error.
  std::string first_error() const {
    for (const Diagnostic& d : diagnostics.list())
      if (d.severity == Severity::kError)
        return std::to_string(d.line) + ":" + std::to_string(d.column) + ": " + d.message;
    return "";
  }
  const Diagnostic* error() const {
    for (const Diagnostic& d : diagnostics.list())
      if (d.severity == Severity::kError) return &d;
    return nullptr;
  }
  std::string all() const { return format_diagnostics(diagnostics, false); }

  Diagnostics diagnostics;
  std::optional<ProblemSpec> spec;
  std::optional<BuiltProblem> built;
};

/// "line:column: message (hint)" of the warnings for a correct text, one a line.
inline std::string warnings(const std::string& text) {
  const Loaded loaded(text);
  EXPECT_TRUE(loaded.built) << loaded.all();
  std::string lines;
  for (const Diagnostic& d : loaded.diagnostics.list())
    if (d.severity == Severity::kWarning)
      lines += fmt::format("{}:{}: {} ({})\n", d.line, d.column, d.message, d.hint);
  return lines;
}

/// hopper_cycle with free durations of its push and its flight.
inline std::string hopper_with_free_durations() {
  std::stringstream file;
  file << std::ifstream(kProblems / "hopper_cycle.yaml").rdbuf();
  const std::string bounds = ", free_duration: {lower: 0.1, upper: 0.4}}";
  const std::string push = replaced(file.str(), "knots: 20, dt: 0.01, contacts: all}",
                                    "knots: 20, dt: 0.01, contacts: all" + bounds);
  return replaced(push, "knots: 25, dt: 0.01}", "knots: 25, dt: 0.01" + bounds);
}

}  // namespace conddp
