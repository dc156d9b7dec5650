#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "process.hpp"

namespace conddp {
namespace {

/// A block that falls 0.1 m while it is pushed 0.1 m to the side.
constexpr const char* kFallingBlock = R"(conddp: 1
name: falling_block
robot: {urdf: robots/block.urdf, actuation: {joints: [base_x]}}
initial_state: {joints: {base_z: 0.6}}
contact_candidates:
  rear: {frame: corner_1, friction: 0.5}
  front: {frame: corner_2, friction: 0.5}
stepping: {plane: [0, 1, 0]}
phases: [{name: fall, knots: 16, dt: 0.02}]
costs: {effort: {residual: control, weight: 1.0e-2}}
terminal:
  constraints:
    there: {residual: joint_position, joints: [base_x], reference: 0.1}
    rest: {residual: joint_velocity, joints: [base_x]}
solver: {name: ipopt}
)";

/// A block that nothing drives: it falls on an edge, tips and slides, and each step is determined.
constexpr const char* kTippingBlock = R"(conddp: 1
name: tipping_block
robot: {urdf: robots/block.urdf, actuation: {joints: [base_x]}}
initial_state: {joints: {base_z: 0.9, base_pitch: 0.3}, velocity: {joints: {base_x: 1.5}}}
contact_candidates:
  rear: {frame: corner_1, friction: 0.4}
  front: {frame: corner_2, friction: 0.4}
stepping: {plane: [0, 1, 0]}
phases: [{name: fall, knots: 30, dt: 0.02}]
constraints: {none: {bounds: control, lower: 0, upper: 0}}
costs: {speed: {residual: state, columns: ["v/*"], weight: 1.0e-6}}
)";

class Contacts : public testing::Test {
 protected:
  Contacts() {
    folder_.write("falling.yaml", kFallingBlock);
    std::filesystem::create_directory(folder_.path() / "robots");
    for (const char* robot : {"block", "cartpole"}) {
      const std::string file = std::string("robots/") + robot + ".urdf";
      folder_.write(file, read_file(source("problems/" + file)));
    }
  }
  ProcessResult run(const std::vector<std::string>& arguments) const {
    return run_conddp(arguments, {.folder = folder_.path()});
  }
  TemporaryFolder folder_;
};

TEST_F(Contacts, FoundContactsAreScheduledAndRefined) {
  const ProcessResult solved = run({"solve", "falling.yaml", "-o", "out"});
  ASSERT_EQ(solved.exit_code, 0) << solved.out << solved.err;
  EXPECT_NE(solved.out.find("\n  contacts      complementarity "), std::string::npos) << solved.out;

  const ProcessResult verified = run({"verify", "out/solution.json"});
  EXPECT_EQ(verified.exit_code, 0) << verified.out << verified.err;
  for (const char* line : {"\n  ok    contact stepping ", "\n  ok    force at a distance ",
                           "\n  sequence: ", "\n  each step by the simulator: "})
    EXPECT_NE(verified.out.find(line), std::string::npos) << line << verified.out;
  const std::string json = run({"verify", "out/solution.json", "--json"}).out;
  for (const auto& [schema, file] :
       {std::pair{"verify", folder_.write("verified.json", json)},
        std::pair{"solution", (folder_.path() / "out/solution.json").string()}}) {
    const std::string command = source("scripts/validate_json") + " " +
                                source("schemas/" + std::string(schema) + ".schema.json") + " " +
                                file + " >&2";
    EXPECT_EQ(std::system(command.c_str()), 0) << schema;
  }

  // It falls freely and lands between two knots. Refinement needs costs on landings.
  const ProcessResult written =
      run({"contacts", "out/solution.json", "-o", "scheduled.yaml", "--solver", "box_fddp"});
  EXPECT_EQ(written.exit_code, 0) << written.err;
  EXPECT_NE(written.out.find("x none ("), std::string::npos) << written.out;
  EXPECT_NE(written.out.find("rear+front"), std::string::npos) << written.out;
  EXPECT_NE(read_file(folder_.path() / "scheduled.yaml").find("impulse:"), std::string::npos);
  const ProcessResult refined = run({"solve", "scheduled.yaml", "-o", "refined"});
  EXPECT_EQ(refined.exit_code, 0) << refined.out << refined.err;
  EXPECT_NE(refined.out.find("certificate   certified local minimum"), std::string::npos)
      << refined.out;
}

TEST_F(Contacts, NamesUnconvergedAnswers) {
  ASSERT_EQ(
      run({"solve", "falling.yaml", "-o", "out", "--quiet", "--set", "solver.max_iterations=1"})
          .exit_code,
      1);
  const ProcessResult written = run({"contacts", "out/solution.json", "-o", "scheduled.yaml"});
  EXPECT_NE(written.err.find("did not converge (max_iterations)"), std::string::npos)
      << written.err;
}

TEST_F(Contacts, DeterminedMotionIsSolved) {
  folder_.write("tipping.yaml", kTippingBlock);
  const ProcessResult solved = run({"solve", "tipping.yaml", "-o", "out"});
  EXPECT_EQ(solved.exit_code, 0) << solved.out << solved.err;
  EXPECT_NE(solved.out.find("certificate   certified local minimum"), std::string::npos)
      << solved.out;
}

TEST_F(Contacts, OtherSolutionsHaveNoContacts) {
  folder_.write("cartpole.yaml", read_file(source("problems/cartpole_swingup.yaml")));
  ASSERT_EQ(run({"solve", "cartpole.yaml", "-o", "out", "--quiet"}).exit_code, 0);
  const ProcessResult r = run({"contacts", "out/solution.json", "-o", "scheduled.yaml"});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("no 'contact_candidates'"), std::string::npos) << r.err;
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "scheduled.yaml"));
}

}  // namespace
}  // namespace conddp
